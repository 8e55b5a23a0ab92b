//! Numbers as text by integer arithmetic: several times faster than general formatting.

use crate::math::Real;

/// Appends `number` with at most so many `decimals`, without trailing zeros.
pub(crate) fn put_number(text: &mut Vec<u8>, number: Real, decimals: u32) {
    let unit = 10_u64.pow(decimals);
    let scaled = (number * unit as Real).round();
    if scaled.is_nan() || scaled.abs() >= 1e18 {
        text.extend(number.to_string().bytes());
        return;
    }
    if scaled < 0.0 {
        text.push(b'-');
    }
    let scaled = scaled.abs() as u64;
    put_digits(text, scaled / unit);
    let mut rest = scaled % unit;
    if rest > 0 {
        text.push(b'.');
        let mut place = unit / 10;
        while rest > 0 {
            text.push(b'0' + (rest / place) as u8);
            rest %= place;
            place /= 10;
        }
    }
}

/// Appends `number`.
pub(crate) fn put_digits(text: &mut Vec<u8>, mut number: u64) {
    let mut reversed = [0_u8; 20];
    let mut start = reversed.len();
    while number > 0 || start == reversed.len() {
        start -= 1;
        reversed[start] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    text.extend(&reversed[start..]);
}
