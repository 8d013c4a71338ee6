//! The few letters that a legend needs, five pixels wide and seven high.
//!
//! Idea: a font file or a font crate would be larger than this whole rasteriser, and numbers with a unit need twenty
//! characters. Each is seven rows of five bits, the highest bit on the left.

/// Columns of a letter, and of a letter with the gap after it.
pub(crate) const WIDTH: usize = 5;
pub(crate) const ADVANCE: usize = WIDTH + 1;
/// Rows of a letter.
pub(crate) const HEIGHT: usize = 7;

const LETTERS: [(char, [u8; HEIGHT]); 18] = [
    ('0', [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110]),
    ('1', [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('2', [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111]),
    ('3', [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110]),
    ('4', [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010]),
    ('5', [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110]),
    ('6', [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110]),
    ('7', [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000]),
    ('8', [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110]),
    ('9', [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100]),
    ('.', [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100]),
    ('-', [0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000]),
    ('/', [0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000]),
    ('e', [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110]),
    ('l', [0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110]),
    ('m', [0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101]),
    ('W', [0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b11011, 0b10001]),
    ('x', [0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001]),
];

/// Whether a letter is inked in a column and row. A letter that is not in the list is a gap.
pub(crate) fn inked(letter: char, column: usize, row: usize) -> bool {
    let rows = LETTERS.iter().find(|(known, _)| *known == letter).map(|(_, rows)| rows);
    rows.is_some_and(|rows| rows[row] >> (WIDTH - 1 - column) & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_has_ink_and_a_shape_of_its_own() {
        for (i, (letter, rows)) in LETTERS.iter().enumerate() {
            assert!(rows.iter().any(|&row| row != 0) && rows.iter().all(|&row| row < 32), "{letter}");
            assert!(LETTERS[..i].iter().all(|(other, shape)| other != letter && shape != rows), "{letter}");
        }
    }

    #[test]
    fn letters_are_upright_and_not_mirrored() {
        let drawn: Vec<String> = (0..HEIGHT)
            .map(|row| (0..WIDTH).map(|column| if inked('7', column, row) { '#' } else { '.' }).collect())
            .collect();
        assert_eq!(drawn, ["#####", "....#", "...#.", "..#..", ".#...", ".#...", ".#..."]);
        assert!(!inked(' ', 0, 0));
    }
}
