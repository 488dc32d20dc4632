//! Numbers that look random and are functions of what they are made for: the finalizer of SplitMix64.

/// 64 bits, well mixed, that depend on a number alone.
pub(crate) fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number in [-1, 1) that depends on another alone.
pub(crate) fn noise(number: u64) -> f32 {
    (mixed(number) >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}
