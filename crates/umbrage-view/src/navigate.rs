//! Hands on mouse and keyboard, and what they do to the viewpoint.
//!
//! The scene follows the hand: around it, the eye goes the other way; in it, the head does.

use eframe::egui::{Context, Key, PointerButton, Pos2, Response, Vec2};
use glam::DVec3;

use crate::viewpoint::Viewpoint;

/// Degrees per point of a drag around the scene, and of the head.
const AROUND_DEG: f64 = 0.4;
const HEAD_DEG: f64 = 0.2;
/// Degrees per press of an arrow key.
const STEP_DEG: f64 = 5.0;
/// How much nearer a point of scrolling brings, as the exponent of a factor; and a press of a key.
const PER_SCROLL: f64 = 0.003;
const PER_KEY: f64 = 0.9;
/// Seconds that a walk through the scene takes, and how much faster it goes with Shift.
const WALK_S: f64 = 8.0;
const FAST: f64 = 3.0;
/// A frame that took longer counts as this long, in seconds.
const LONGEST_FRAME_S: f64 = 0.1;

/// Keys that walk: right, up, ahead.
const WALK: [(Key, DVec3); 6] = [
    (Key::W, DVec3::Z),
    (Key::S, DVec3::NEG_Z),
    (Key::D, DVec3::X),
    (Key::A, DVec3::NEG_X),
    (Key::E, DVec3::Y),
    (Key::Q, DVec3::NEG_Y),
];

/// What is asked for besides moving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Asked {
    /// Tell of the point at this place of the window.
    Pick(Pos2),
    /// Turn to it, and around it from now on.
    Centre(Pos2),
    /// See the whole scene.
    Fit,
    /// Go back to where the view began.
    Begin,
    /// Show or hide the panel.
    Panel,
}

/// Moves `view` as the hands on the scene, which is `size_m` large, say.
pub(crate) fn navigate(response: &Response, view: &mut Viewpoint, size_m: f64, around: bool) -> Option<Asked> {
    let ctx = &response.ctx;
    if response.is_pointer_button_down_on() {
        // Keys belong to the view from now on.
        ctx.memory_mut(|memory| memory.focused().map(|id| memory.surrender_focus(id)));
    }
    drag(response, view, around);
    if response.hovered() {
        let (scroll, pinch) = ctx.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
        if scroll != 0.0 || pinch != 1.0 {
            view.approach((-PER_SCROLL * f64::from(scroll)).exp() / f64::from(pinch), size_m);
        }
    }
    let place = response.interact_pointer_pos();
    if let (true, Some(place)) = (response.double_clicked(), place) {
        return Some(Asked::Centre(place));
    }
    if let (true, Some(place)) = (response.clicked(), place) {
        return Some(Asked::Pick(place));
    }
    if ctx.wants_keyboard_input() { None } else { keys(ctx, view, size_m, around) }
}

fn drag(response: &Response, view: &mut Viewpoint, around: bool) {
    let delta = response.drag_delta();
    if delta == Vec2::ZERO {
        return;
    }
    let slides = response.dragged_by(PointerButton::Secondary)
        || response.dragged_by(PointerButton::Middle)
        || response.ctx.input(|input| input.modifiers.shift);
    let (x, y) = (f64::from(delta.x), f64::from(delta.y));
    if slides {
        // What is in the middle moves along with the pointer.
        let height = f64::from(response.rect.height().max(1.0));
        let metres = 2.0 * view.distance_m() * (0.5 * view.fov_y_deg.to_radians()).tan() / height;
        view.walk(DVec3::new(-x * metres, y * metres, 0.0));
    } else {
        turn(view, if around { AROUND_DEG } else { -HEAD_DEG }, [x, -y], around);
    }
}

fn turn(view: &mut Viewpoint, degrees: f64, [right, up]: [f64; 2], around: bool) {
    let (yaw, pitch) = ((degrees * right).to_radians(), (degrees * up).to_radians());
    if around { view.orbit(yaw, pitch) } else { view.turn(yaw, pitch) }
}

fn keys(ctx: &Context, view: &mut Viewpoint, size_m: f64, around: bool) -> Option<Asked> {
    let (by, fast, seconds) = ctx.input(|input| {
        // With Ctrl they mean something else.
        let held = WALK.iter().filter(|(key, _)| !input.modifiers.command && input.key_down(*key));
        (held.map(|(_, by)| *by).sum::<DVec3>(), input.modifiers.shift, f64::from(input.stable_dt))
    });
    if by != DVec3::ZERO {
        let metres = seconds.min(LONGEST_FRAME_S) * size_m / WALK_S * if fast { FAST } else { 1.0 };
        view.walk(metres * by);
        ctx.request_repaint();
    }
    let pressed = |key: Key| ctx.input(|input| input.num_presses(key)) as f64;
    let right = pressed(Key::ArrowRight) - pressed(Key::ArrowLeft);
    let up = pressed(Key::ArrowUp) - pressed(Key::ArrowDown);
    if right != 0.0 || up != 0.0 {
        turn(view, STEP_DEG, [right, up], around);
    }
    let nearer = pressed(Key::Plus) + pressed(Key::Equals) - pressed(Key::Minus);
    if nearer != 0.0 {
        view.approach(PER_KEY.powf(nearer), size_m);
    }
    [(Key::F, Asked::Fit), (Key::Home, Asked::Begin), (Key::P, Asked::Panel)]
        .into_iter()
        .find_map(|(key, asked)| (pressed(key) > 0.0).then_some(asked))
}

#[cfg(test)]
mod tests {
    use eframe::egui::{CentralPanel, Event, Modifiers, MouseWheelUnit, RawInput, Rect, Sense, pos2, vec2};
    use umbrage_picture::Camera;

    use super::*;

    fn view() -> Viewpoint {
        Viewpoint::new(&Camera::looking(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 40.0))
    }

    /// A window in which these events happen, frame after frame.
    fn after(frames: &[&[Event]], around: bool) -> (Viewpoint, Vec<Asked>) {
        let (ctx, mut view, mut asked) = (Context::default(), view(), Vec::new());
        for events in frames {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(400.0, 400.0)));
            let input = RawInput { screen_rect, events: events.to_vec(), ..RawInput::default() };
            let _ = ctx.run(input, |ctx| {
                CentralPanel::default().show(ctx, |ui| {
                    let response = ui.allocate_rect(ui.max_rect(), Sense::click_and_drag());
                    asked.extend(navigate(&response, &mut view, 8.0, around));
                });
            });
        }
        (view, asked)
    }

    fn press(key: Key) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }
    }

    fn button(pressed: bool, at: Pos2) -> Event {
        Event::PointerButton { pos: at, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    #[test]
    fn w_walks_ahead_and_d_to_the_right() {
        let (walked, _) = after(&[&[], &[press(Key::W)]], true);
        let by = walked.eye_m - view().eye_m;
        assert!(by.z < 0.0 && by.x.abs() < 1e-12 && by.y.abs() < 1e-12, "{by}");
        let (walked, _) = after(&[&[], &[press(Key::D)]], true);
        assert!(walked.eye_m.x > 0.0 && (walked.eye_m.z - 5.0).abs() < 1e-12);
    }

    #[test]
    fn arrows_turn_by_five_degrees_around_the_scene_or_on_the_spot() {
        let (around, _) = after(&[&[], &[press(Key::ArrowRight)]], true);
        assert!(around.target_m().length() < 1e-12 && around.eye_m.x < 0.0);
        let (on_the_spot, _) = after(&[&[], &[press(Key::ArrowRight)]], false);
        assert_eq!(on_the_spot.eye_m, view().eye_m);
        for turned in [around, on_the_spot] {
            assert!((turned.ahead().dot(view().ahead()) - 5f64.to_radians().cos()).abs() < 1e-12);
        }
    }

    #[test]
    fn a_drag_turns_and_a_click_asks() {
        let [from, to] = [pos2(200.0, 200.0), pos2(260.0, 200.0)];
        let drag: &[&[Event]] =
            &[&[Event::PointerMoved(from)], &[button(true, from)], &[Event::PointerMoved(to)], &[button(false, to)]];
        let (dragged, asked) = after(drag, true);
        // The scene follows the hand to the right: the eye goes to the left.
        assert!(dragged.eye_m.x < 0.0 && dragged.target_m().length() < 1e-9 && asked.is_empty(), "{dragged:?}");
        let click: &[&[Event]] = &[&[Event::PointerMoved(from)], &[button(true, from)], &[button(false, from)]];
        let (clicked, asked) = after(click, true);
        assert_eq!((clicked, asked), (view(), vec![Asked::Pick(from)]));
    }

    #[test]
    fn the_wheel_brings_nearer() {
        let (unit, delta) = (MouseWheelUnit::Line, vec2(0.0, 3.0));
        let wheel = Event::MouseWheel { unit, delta, modifiers: Modifiers::NONE };
        let (nearer, _) = after(&[&[Event::PointerMoved(pos2(200.0, 200.0))], &[wheel], &[], &[]], true);
        assert!(nearer.distance_m() < 4.9 && nearer.target_m().length() < 1e-9, "{nearer:?}");
    }
}
