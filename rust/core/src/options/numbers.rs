//! Numbers as people write them on a command line: in, text; out, whole numbers, and sizes of files in bytes, and times in seconds.

/// A float as the whole number that it is, such as 1e5: the largest of which all are exact is 2^53.
pub(super) fn exact(number: f64) -> Option<u64> {
    (number.fract() == 0.0 && (0.0..=(1u64 << 53) as f64).contains(&number)).then_some(number as u64)
}

/// A whole number of at least 0: `100000`, `100_000`, `1e5`, `100k` or `0.1M`.
pub fn whole(text: &str) -> Option<u64> {
    let is_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let joined = text.split('_').all(is_digits).then(|| text.replace('_', ""));
    if let Some(number) = joined.and_then(|digits| digits.parse().ok()) {
        return Some(number);
    }
    // As a power of ten the factor is exact: 1.001k is 1001.
    let number = match (text.strip_suffix(['k', 'K']), text.strip_suffix('M')) {
        (Some(thousands), _) => format!("{thousands}e3"),
        (None, Some(millions)) => format!("{millions}e6"),
        (None, None) => text.to_owned(),
    };
    exact(number.parse().ok()?)
}

/// Units of the sizes of files, those first that end in others.
const UNITS: [(&str, f64); 10] = [
    ("kib", 1024.0),
    ("mib", 1_048_576.0),
    ("gib", 1_073_741_824.0),
    ("kb", 1e3),
    ("mb", 1e6),
    ("gb", 1e9),
    ("k", 1e3),
    ("m", 1e6),
    ("g", 1e9),
    ("b", 1.0),
];

/// A size of a file in whole bytes: a number of them, or one with a unit such as `100kB`, `1.5MB` or `100KiB`.
pub(crate) fn bytes(text: &str) -> Option<u64> {
    let text = text.trim().to_ascii_lowercase();
    let unit = UNITS.iter().find(|(unit, _)| text.ends_with(unit));
    let Some((unit, factor)) = unit else { return whole(&text) };
    let number: f64 = text[..text.len() - unit.len()].trim_end().parse().ok()?;
    exact((number * factor).floor())
}

/// A time in whole seconds: a number with a unit, such as `2h`, `90min` or `45s`, or several from the largest unit on: `1h30min`.
pub fn seconds(text: &str) -> Option<u64> {
    let mut rest = text.trim();
    let mut sum = 0.0;
    let mut last = f64::INFINITY;
    while !rest.is_empty() {
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.')?;
        let number: f64 = rest[..end].parse().ok()?;
        rest = rest[end..].trim_start();
        let (unit, factor) =
            [("h", 3600.0), ("min", 60.0), ("m", 60.0), ("s", 1.0)].into_iter().find(|(unit, _)| rest.starts_with(unit))?;
        if factor >= last {
            return None;
        }
        (sum, last) = (sum + number * factor, factor);
        rest = rest[unit.len()..].trim_start();
    }
    last.is_finite().then(|| exact(sum.floor())).flatten()
}

/// A time as people write it: `2h 5min`, `90s`.
pub(crate) fn in_hours(seconds: u64) -> String {
    match (seconds / 3600, seconds % 3600 / 60, seconds % 60) {
        (0, minutes, seconds) if minutes < 2 => format!("{}s", 60 * minutes + seconds),
        (0, minutes, seconds) => format!("{}min", minutes + u64::from(seconds > 0)),
        (hours, minutes, seconds) => format!("{hours}h {}min", minutes + u64::from(seconds > 0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read_as_people_write_them() {
        for (text, number) in [
            ("7", 7),
            ("100_000", 100_000),
            ("1e5", 100_000),
            ("1E5", 100_000),
            ("100k", 100_000),
            ("100K", 100_000),
            ("1.001k", 1001),
            ("1.5M", 1_500_000),
            ("12.0", 12),
            ("9007199254740993", 9_007_199_254_740_993),
        ] {
            assert_eq!(whole(text), Some(number), "{text}");
        }
        for text in
            ["", "k", "1.0005k", "1e5k", "0.5", "-1", "-1k", "1e300", "inf", "nan", "_1", "1_", "1__0", "1_0k", "10m", "1 k"]
        {
            assert_eq!(whole(text), None, "{text}");
        }
    }

    #[test]
    fn sizes_of_files_have_units() {
        for (text, number) in [
            ("100kB", 100_000),
            ("100 kb", 100_000),
            ("100KiB", 102_400),
            ("1MB", 1_000_000),
            ("1.5MiB", 1_572_864),
            ("2GB", 2_000_000_000),
            ("1GiB", 1_073_741_824),
            ("100k", 100_000),
            ("5M", 5_000_000),
            ("500", 500),
            ("500B", 500),
            ("1e5", 100_000),
            ("1.0005kB", 1000),
            ("0.1B", 0),
        ] {
            assert_eq!(bytes(text), Some(number), "{text}");
        }
        for text in ["", "kB", "-5kB", "many", "1TBq", "nan kB", "inf", "1e300MB"] {
            assert_eq!(bytes(text), None, "{text}");
        }
    }

    #[test]
    fn times_are_read_as_people_write_them() {
        for (text, number) in
            [("2h", 7200), ("90min", 5400), ("90m", 5400), ("1.5h", 5400), ("1h30min", 5400), ("1h 30m 5s", 5405), ("45s", 45)]
        {
            assert_eq!(seconds(text), Some(number), "{text}");
        }
        for text in ["", "2", "h", "-2h", "2d", "30min1h", "1h1h", "1.2.3h", "inf h", "2h3"] {
            assert_eq!(seconds(text), None, "{text}");
        }
        assert_eq!([45, 119, 120, 121, 7200, 7201].map(in_hours), ["45s", "119s", "2min", "3min", "2h 0min", "2h 1min"]);
    }
}
