//! Letters as pen strokes, drawn for this project.
//!
//! A stroke is a mark and then points, two hexadecimal digits each, x then y. Descenders reach down to 0; the baseline is
//! 3, small letters rise to 9, capitals to c. `/` joins its points by straight lines, `~` is a smooth curve pulled towards
//! its points, `o` a closed one.

use crate::math::Real;

/// Height of the baseline in font units.
pub(super) const BASELINE: Real = 3.0;
/// Height of a capital above the baseline in font units.
pub(super) const CAPITAL: Real = 9.0;
/// Free space after a letter in font units.
const GAP: Real = 2.6;
/// Width of a blank in font units.
const BLANK: Real = 3.0;

/// Polylines of `letter` in font units, and how far the pen moves on. An unknown letter is an empty box.
pub(super) fn strokes(letter: char) -> (Vec<Vec<[Real; 2]>>, Real) {
    if letter == ' ' {
        return (Vec::new(), BLANK + GAP);
    }
    let strokes: Vec<_> = glyph(letter).split(' ').map(stroke).collect();
    let width = strokes.iter().flatten().fold(0.0, |w: Real, p| w.max(p[0]));
    (strokes, width + GAP)
}

fn stroke(text: &str) -> Vec<[Real; 2]> {
    let (mark, digits) = text.split_at(1);
    let digits: Vec<Real> = digits
        .chars()
        .map(|c| Real::from(c.to_digit(16).expect("the table is in hexadecimal")))
        .collect();
    let points: Vec<[Real; 2]> = digits.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    match mark {
        "~" => smooth(points, false),
        "o" => smooth(points, true),
        _ => points,
    }
}

/// Cuts corners three times (Chaikin), which approaches a quadratic B-spline; an open curve keeps its ends.
fn smooth(mut points: Vec<[Real; 2]>, closed: bool) -> Vec<[Real; 2]> {
    for _ in 0..3 {
        let n = points.len();
        let mut finer = Vec::with_capacity(2 * n);
        for i in 0..if closed { n } else { n - 1 } {
            let (p, q) = (points[i], points[(i + 1) % n]);
            let at = |t: Real| [p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t];
            finer.push(at(if !closed && i == 0 { 0.0 } else { 0.25 }));
            finer.push(at(if !closed && i == n - 2 { 1.0 } else { 0.75 }));
        }
        points = finer;
    }
    if closed {
        points.push(points[0]);
    }
    points
}

fn glyph(letter: char) -> &'static str {
    match letter {
        '0' => "o0c6c6303",
        '1' => "/0a3c33",
        '2' => "~0a0c6c6803 /0363",
        '3' => "~0b0c5c5828 ~2868630305",
        '4' => "/434c0666",
        '5' => "/5c0c08 ~0869630304",
        '6' => "~5c0c06 o09696303",
        '7' => "/0c6c23",
        '8' => "o1c5c5818 o08686303",
        '9' => "o0c6c6606 ~696313",
        'A' => "/033c63 /1656",
        'B' => "/3c0c0333 /0838 ~3c5c5838 ~38686333",
        'C' => "~6a6c0c036365",
        'D' => "/2c0c0323 ~2c6c6323",
        'E' => "/5c0c0353 /0848",
        'F' => "/5c0c03 /0848",
        'G' => "~6a6c0c036367 /3767",
        'H' => "/030c /636c /0868",
        'I' => "/030c",
        'J' => "/4c46 ~46430305",
        'K' => "/030c /5c0753",
        'L' => "/0c0353",
        'M' => "/030c478c83",
        'N' => "/030c636c",
        'O' => "o0c7c7303",
        'P' => "/030c3c /0737 ~3c6c6737",
        'Q' => "o0c7c7303 /4673",
        'R' => "/030c3c /0737 ~3c6c6737 /3763",
        'S' => "~6a6c0c0868630305",
        'T' => "/0c6c /3c33",
        'U' => "/0c06 /6c66 ~06036366",
        'V' => "/0c336c",
        'W' => "/0c234c638c",
        'X' => "/0c63 /036c",
        'Y' => "/0c386c /3833",
        'Z' => "/0c6c0363",
        'a' => "o09595303 /5953",
        'b' => "/0c03 o09595303",
        'c' => "~584909034354",
        'd' => "/5c53 o09595303",
        'e' => "/0656 ~565909035354",
        'f' => "~4c1c18 /1813 /0939",
        'g' => "o09595303 /5952 ~52500001",
        'h' => "/0c03 ~06095956 /5653",
        'i' => "/0903 /0c0c",
        'j' => "/2922 ~222000 /2c2c",
        'k' => "/0c03 /490643",
        'l' => "/0c03",
        'm' => "/0903 ~06094946 /4643 ~46498986 /8683",
        'n' => "/0903 ~06095956 /5653",
        'o' => "o09595303",
        'p' => "/0900 o09595303",
        'q' => "/5950 o09595303",
        'r' => "/0903 ~060939",
        's' => "~485909065653430304",
        't' => "/1c15 ~151343 /0939",
        'u' => "/0906 ~06035356 /5953",
        'v' => "/093369",
        'w' => "/0923496389",
        'x' => "/0953 /0359",
        'y' => "/0933 /6920",
        'z' => "/09590353",
        '.' => "o03131404",
        ',' => "/1301",
        ':' => "o04141505 o08181909",
        ';' => "/1301 /1818",
        '!' => "/0c06 /0303",
        '?' => "~0a0c5c582826 /2323",
        '\'' => "/0c0a",
        '"' => "/0c0a /2c2a",
        '-' => "/0747",
        '–' => "/0767",
        '−' => "/0666",
        '+' => "/0666 /3933",
        '±' => "/0868 /3b35 /0363",
        '=' => "/0565 /0868",
        '<' => "/590653",
        '>' => "/095603",
        '×' => "/0954 /0459",
        '·' => "/0707",
        '*' => "/3b37 /1a58 /185a",
        '/' => "/015c",
        '\\' => "/0c51",
        '|' => "/0d01",
        '_' => "/0262",
        '(' => "~2d0b0321",
        ')' => "~0d2b2301",
        '[' => "/2d0d0121",
        ']' => "/0d2d2101",
        '{' => "~3d1d1707 ~07171131",
        '}' => "~0d2d2737 ~37272101",
        '%' => "o0c3c3808 o47777343 /136c",
        '#' => "/2c13 /5c43 /0969 /0666",
        '&' => "~63191c4c4905035366",
        '^' => "/092c49",
        '~' => "~0719374768",
        '`' => "/0c2a",
        '$' => "~6a6c0c0868630305 /3d32",
        '@' => "o28585525 /5855 ~55848b6c2c09032363",
        '°' => "o0c3c3909",
        'µ' | 'μ' => "/0900 ~06035356 /5953",
        '²' => "~0a0c3c3a07 /0737",
        '³' => "~0c3c3a1a ~1a3a3707",
        _ => "/030c5c5303",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_letter_has_its_own_strokes_inside_the_cell() {
        let mut seen = std::collections::BTreeSet::new();
        for letter in ('!'..='~').chain("–−±×·°µ²³".chars()) {
            assert!(seen.insert(glyph(letter)), "{letter} looks like another");
            let (strokes, advance) = strokes(letter);
            assert!(!strokes.is_empty() && advance > 0.0);
            for point in strokes.iter().flatten() {
                assert!((0.0..=8.0).contains(&point[0]) && (0.0..=13.0).contains(&point[1]));
            }
        }
    }
}
