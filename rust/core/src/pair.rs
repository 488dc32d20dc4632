//! Two numbers that are reckoned with at once, for sums over many points that processors do two at a time.
//!
//! Each of the two is what it would be alone, to the last bit.

use std::ops::{Add, Mul, Neg, Sub};

/// Two numbers side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair(pub(crate) [f64; 2]);

impl Pair {
    /// The same number twice.
    #[inline(always)]
    pub(crate) fn of(value: f64) -> Self {
        Self([value; 2])
    }

    /// A number made from each of both.
    #[inline(always)]
    pub(crate) fn map(self, one: impl Fn(f64) -> f64) -> Self {
        Self([one(self.0[0]), one(self.0[1])])
    }

    /// A number made from each of both and its partner.
    #[inline(always)]
    pub(crate) fn with(self, other: Self, one: impl Fn(f64, f64) -> f64) -> Self {
        Self([one(self.0[0], other.0[0]), one(self.0[1], other.0[1])])
    }
}

impl Add for Pair {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for Pair {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl Mul for Pair {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
}

impl Mul<f64> for Pair {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|a| a * other)
    }
}

impl Neg for Pair {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}
