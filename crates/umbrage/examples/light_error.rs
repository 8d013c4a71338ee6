//! temp
use glam::DVec3;
use rayon::prelude::*;
use std::time::Instant;
use umbrage::discontinuity;
use umbrage::geometry::polygon;
use umbrage::mesh::{Mesh, MeshSettings};
use umbrage::prepare;
use umbrage::progress::Progress;
use umbrage::shade::Irradiance;
use umbrage::solve::{self, SolveSettings, Surfaces};
use umbrage::transport::{self, FormFactorOracle};
use umbrage::visibility::{ReceiverPoint, Visibility};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let name = &args[1];
    let f_max: f64 = args[2].parse().unwrap();
    let share: f64 = args[3].parse().unwrap();
    let (scene, _) = umbrage_formats::read_scene(format!("/work/shared/scenes/{name}.glb")).unwrap();
    let t = Instant::now();
    let prepared = prepare::prepare(&scene, Progress::silent()).unwrap();
    let visibility = Visibility::new(&prepared);
    let d = discontinuity::find(&scene, &prepared, &visibility, Progress::silent()).unwrap();
    println!("prepare+d {:.3}", t.elapsed().as_secs_f64());
    let t = Instant::now();
    let mut mesh = Mesh::new(&prepared, &d.segments, MeshSettings::default());
    let total: f64 = prepared.faces.keys().map(|face| polygon::area_m2(&prepared.polygon_m(face))).sum();
    let oracle = FormFactorOracle {
        max_form_factor: f_max,
        min_area_m2: share * total,
        coplanar_m: prepared.tolerance.coplanar_m(),
    };
    let links = transport::link_all(&prepared, &visibility, &mut mesh, &oracle, Progress::silent()).unwrap();
    println!(
        "faces {} patches {} leaves {} links {} transport {:.3}",
        prepared.faces.len(),
        mesh.patch_count(),
        mesh.leaves().count(),
        links.len(),
        t.elapsed().as_secs_f64()
    );
    let t = Instant::now();
    let direct = umbrage::transport::DirectLight::new(&scene, &prepared, &visibility);
    let surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
    println!("direct {:.3}", t.elapsed().as_secs_f64());
    let t = Instant::now();
    let solution = solve::solve(&mesh, &surfaces, &links, SolveSettings::default(), Progress::silent()).unwrap();
    println!("solve {:.3} iterations {}", t.elapsed().as_secs_f64(), solution.iterations);
    let light = Irradiance::new(&prepared, &visibility, &mesh, &links, &direct, &solution);
    let light = Irradiance::new(&prepared, &visibility, &mesh, &links, &direct, &solution);
    let solution2 =
        umbrage::shade::bounce(&prepared, &mesh, &surfaces, &light, solution.clone(), Progress::silent()).unwrap();
    let light = Irradiance::new(&prepared, &visibility, &mesh, &links, &direct, &solution2);
    let text = std::fs::read_to_string(format!("/work/shared/reference/{name}.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|l| l.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    let t = Instant::now();
    let values: Vec<Option<[DVec3; 2]>> = rows
        .par_iter()
        .map(|r| {
            let p = DVec3::new(r[1], r[2], r[3]) - prepared.origin_m;
            let n = DVec3::new(r[4], r[5], r[6]);
            let face = prepared
                .faces
                .keys()
                .filter(|&f| {
                    let plane = prepared.oriented_plane(f);
                    if plane.normal.dot(n) < 0.999 || plane.signed_distance_m(p).abs() > 1e-3 {
                        return false;
                    }
                    let c = prepared.polygon_m(f);
                    (0..c.len()).all(|i| (c[(i + 1) % c.len()] - c[i]).cross(p - c[i]).dot(plane.normal) >= -1e-6)
                })
                .next()?;
            let rp = ReceiverPoint::on_face(&prepared, face, p);
            let direct = light.direct(&rp);
            let indirect = light.indirect(&rp, face);
            Some([direct, indirect])
        })
        .collect();
    println!("points {:.3}", t.elapsed().as_secs_f64());
    let mut per: std::collections::BTreeMap<i64, Vec<[DVec3; 4]>> = Default::default();
    let mut all = vec![];
    for (r, v) in rows.iter().zip(&values) {
        let Some(v) = v else { continue };
        let tot = DVec3::new(r[8], r[9], r[10]);
        let dir = DVec3::new(r[14], r[15], r[16]);
        let e = [v[0], v[1], dir, tot - dir];
        per.entry(r[0] as i64).or_default().push(e);
        all.push(e);
    }
    let m3 = |v: DVec3| v.element_sum() / 3.0;
    let mean = all.iter().map(|e| m3(e[2] + e[3])).sum::<f64>() / all.len() as f64;
    let report = |label: String, es: &[[DVec3; 4]]| {
        let n = es.len() as f64;
        let rms = |f: &dyn Fn(&[DVec3; 4]) -> DVec3| {
            (es.iter()
                .map(|e| {
                    let d = f(e);
                    d.dot(d) / 3.0
                })
                .sum::<f64>()
                / n)
                .sqrt()
                / mean
        };
        let bias = |f: &dyn Fn(&[DVec3; 4]) -> DVec3| es.iter().map(|e| m3(f(e))).sum::<f64>() / n / mean;
        println!(
            "{label:8} n {:5} total rms {:.4} bias {:+.4} | direct rms {:.4} bias {:+.4} | indirect rms {:.4} bias {:+.4} | mean dir {:.3} ind {:.3}",
            es.len(),
            rms(&|e| e[0] + e[1] - e[2] - e[3]),
            bias(&|e| e[0] + e[1] - e[2] - e[3]),
            rms(&|e| e[0] - e[2]),
            bias(&|e| e[0] - e[2]),
            rms(&|e| e[1] - e[3]),
            bias(&|e| e[1] - e[3]),
            bias(&|e| e[2]),
            bias(&|e| e[3])
        );
    };
    report("all".into(), &all);
    if args.len() > 4 {
        for (k, es) in &per {
            report(k.to_string(), es);
        }
    }
}
