//! Numbers in files for machines: as short as they can be, and the same everywhere.

/// Decimals of numbers that are no coordinates, such as speeds and times.
const DECIMALS: u32 = 3;

/// Appends a whole number of steps, of which 10 to the power of `decimals` are 1, without zeros at its end.
pub(super) fn push_steps(out: &mut String, steps: i64, decimals: u32) {
    let per_one = 10_u64.pow(decimals);
    let (whole, fraction) = (steps.unsigned_abs() / per_one, steps.unsigned_abs() % per_one);
    if steps < 0 {
        out.push('-');
    }
    push_whole(out, whole, 1);
    if fraction > 0 {
        out.push('.');
        push_whole(out, fraction, decimals as usize);
        out.truncate(out.trim_end_matches('0').len());
    }
}

/// Appends a number that is no coordinate.
pub(super) fn push_number(out: &mut String, value: f64) {
    push_steps(out, (value * 1000.0).round() as i64, DECIMALS);
}

/// A length in mm as text: three decimals at most.
pub(super) fn millimetres(value: f64) -> String {
    let mut text = String::new();
    push_number(&mut text, value);
    text
}

/// Appends a number with zeros before it to `least` digits. Coordinates are most of a file: formatting them with `write!` takes
/// three times as long.
fn push_whole(out: &mut String, mut number: u64, least: usize) {
    let mut digits = [b'0'; 20];
    let mut begin = digits.len();
    while number > 0 {
        begin -= 1;
        digits[begin] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    let begin = begin.min(digits.len() - least);
    out.extend(digits[begin..].iter().map(|digit| char::from(*digit)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let text = |steps, decimals| {
            let mut out = String::new();
            push_steps(&mut out, steps, decimals);
            out
        };
        let shown = [(0, 3), (5, 3), (-50, 3), (1_500, 3), (-12_000, 3), (100_001, 3), (7, 0), (-40, 0), (1_234_567, 6)];
        assert_eq!(
            shown.map(|(steps, decimals)| text(steps, decimals)),
            ["0", "0.005", "-0.05", "1.5", "-12", "100.001", "7", "-40", "1.234567"]
        );
        assert_eq!([0.1, 3000.0, 0.0004, -0.0004, 54.25].map(millimetres), ["0.1", "3000", "0", "0", "54.25"]);
    }
}
