//! Inks proposed for a photo.
//!
//! Inks mix, so what counts is not that every colour has an ink near to it, but that few inks span the photo's colours, with paper.
//! Clusters of the colours say where they are; every ink then moves from the middle of its cluster outwards, through the colours of
//! the photo, as far as it lowers what is judged: how far the photo's colours are from what inks and paper mix, and, counting less, how
//! far apart the inks are that mix them, which is how much noise a drawing has.

use crate::inks::mixture::{MOST_LABELS, Mixing, Mixture, linear, mixtures};
use crate::photo::Field;

/// Bits of each channel by which colours are gathered.
const BITS: u32 = 5;

/// Pixels that are looked at, about.
const LOOKED_AT: usize = 1 << 18;

/// The most colours, those of the most pixels, on which inks are tried.
const TRIED_ON: usize = 600;

const K_MEANS: usize = 8;

/// How often every ink is asked how far out it should be, and the ways it may go.
const ROUNDS: usize = 2;
const OUTWARDS: [f64; 5] = [0.0, 0.5, 1.0, 1.4, 1.8];

/// The weight of the noise of mixtures against their misses.
const NOISE: f64 = 0.15;

type Point = [f64; 3];

/// Colours of a photo that are nearly one.
struct Bin {
    /// Red, green and blue, sRGB-encoded.
    rgb: Point,
    lab: Point,
    /// Share of the photo.
    share: f64,
}

/// Up to `count` inks, at least 1, for a photo on white paper, from dark to light: sRGB in 8 bits, none twice.
///
/// `colour` are the photo's red, green and blue, sRGB-encoded in [0, 1], of one size.
pub fn extract(colour: [&Field; 3], count: usize) -> Vec<[u8; 3]> {
    let bins = gathered(colour);
    let count = count.clamp(1, MOST_LABELS - 1);
    let seeds = seeds(&bins, count);
    let (centres, owners) = clustered(&bins, seeds);
    let inks = spread(&bins, &centres, &owners);
    let mut inks: Vec<[u8; 3]> = inks.into_iter().map(rounded).collect();
    inks.sort_by_key(|[r, g, b]| (299 * u32::from(*r) + 587 * u32::from(*g) + 114 * u32::from(*b), *r, *g, *b));
    inks.dedup();
    inks
}

/// The photo's colours, those of the most pixels first.
fn gathered([red, green, blue]: [&Field; 3]) -> Vec<Bin> {
    let pixels = red.values().len().min(green.values().len()).min(blue.values().len());
    let mut bins = vec![([0.0; 3], 0u32); 1 << (3 * BITS)];
    let (stride, mut looked_at) = (pixels.div_ceil(LOOKED_AT).max(1), 0u32);
    for k in (0..pixels).step_by(stride) {
        let rgb = [red, green, blue].map(|field| f64::from(field.values()[k]).clamp(0.0, 1.0));
        let levels = rgb.map(|v| ((v * f64::from(1u32 << BITS)) as usize).min((1 << BITS) - 1));
        let (sum, count) = &mut bins[(levels[0] << (2 * BITS)) | (levels[1] << BITS) | levels[2]];
        *count += 1;
        looked_at += 1;
        *sum = std::array::from_fn(|channel| sum[channel] + rgb[channel]);
    }
    let filled = bins.into_iter().filter(|(_, count)| *count > 0);
    let bin = |(sum, count): (Point, u32)| {
        let rgb = sum.map(|sum| sum / f64::from(count));
        Bin { rgb, lab: oklab(rgb), share: f64::from(count) / f64::from(looked_at) }
    };
    let mut bins: Vec<Bin> = filled.map(bin).collect();
    // Stable: those of equal shares stay in the order of their colours.
    bins.sort_by(|a, b| b.share.total_cmp(&a.share));
    bins
}

/// Colours far apart: each as far from paper and those before as the root of its share weighs it.
fn seeds(bins: &[Bin], count: usize) -> Vec<Point> {
    let mut distances: Vec<f64> = bins.iter().map(|bin| squared(bin.lab, oklab([1.0; 3]))).collect();
    let mut seeds = Vec::with_capacity(count);
    while seeds.len() < count {
        let score = |k: usize| distances[k] * bins[k].share.sqrt();
        let best = (0..bins.len()).fold(0, |best, k| if score(k) > score(best) { k } else { best });
        if bins.is_empty() || (!seeds.is_empty() && distances[best] < 1e-5) {
            break;
        }
        seeds.push(bins[best].lab);
        for (distance, bin) in distances.iter_mut().zip(bins) {
            *distance = distance.min(squared(bin.lab, bins[best].lab));
        }
    }
    seeds
}

/// The centres of clusters after a few steps of k-means, and the cluster of every colour; those of paper have none.
fn clustered(bins: &[Bin], mut centres: Vec<Point>) -> (Vec<Point>, Vec<Option<usize>>) {
    let paper = oklab([1.0; 3]);
    let mut owners = vec![None; bins.len()];
    for step in 0..K_MEANS {
        let mut sums = vec![([0.0; 3], 0.0); centres.len()];
        for (bin, owner) in bins.iter().zip(&mut owners) {
            let mut nearest = (squared(bin.lab, paper), None);
            for (number, centre) in centres.iter().enumerate() {
                let distance = squared(bin.lab, *centre);
                // In a photo as white as paper, its white is its only ink.
                if distance < nearest.0 || (centres.len() == 1 && distance == nearest.0) {
                    nearest = (distance, Some(number));
                }
            }
            *owner = nearest.1;
            if let Some(number) = *owner {
                let (sum, share) = &mut sums[number];
                *share += bin.share;
                *sum = std::array::from_fn(|axis| sum[axis] + bin.share * bin.lab[axis]);
            }
        }
        if step + 1 < K_MEANS {
            for (centre, (sum, share)) in centres.iter_mut().zip(sums).filter(|(_, (_, share))| *share > 0.0) {
                *centre = sum.map(|sum| sum / share);
            }
        }
    }
    (centres, owners)
}

/// The inks: colours of the clusters, moved outwards as far as it is worth it.
fn spread(bins: &[Bin], centres: &[Point], owners: &[Option<usize>]) -> Vec<Point> {
    let all = mean(bins.iter()).unwrap_or([0.5; 3]);
    let ways: Vec<(Point, Point)> = (0..centres.len())
        .filter_map(|number| {
            let own = || bins.iter().zip(owners).filter(move |(_, owner)| **owner == Some(number)).map(|(bin, _)| bin);
            let middle = mean(own())?;
            let out = minus(middle, all);
            // The tenth of the cluster that lies farthest out.
            let mut along: Vec<(f64, &Bin)> = own().map(|bin| (dot(minus(bin.rgb, middle), out), bin)).collect();
            along.sort_by(|a, b| b.0.total_cmp(&a.0));
            let wanted = 0.1 * along.iter().map(|(_, bin)| bin.share).sum::<f64>();
            let (mut share, mut outer) = (0.0, 0);
            while outer < along.len() && share < wanted {
                share += along[outer].1.share;
                outer += 1;
            }
            let rim = mean(along[..outer].iter().map(|(_, bin)| *bin))?;
            Some((middle, minus(rim, middle)))
        })
        .collect();
    let tried_on: Vec<&Bin> = bins.iter().take(TRIED_ON).collect();
    let colours: Vec<[f32; 3]> = tried_on.iter().map(|bin| bin.rgb.map(|v| v as f32)).collect();
    let ink = |number: usize, far: f64| {
        let (middle, way) = ways[number];
        std::array::from_fn(|channel| (middle[channel] + far * way[channel]).clamp(0.0, 1.0))
    };
    let mut fars = vec![1.0; ways.len()];
    let judged = |fars: &[f64]| {
        let mut labels: Vec<[u8; 3]> = fars.iter().enumerate().map(|(number, far)| rounded(ink(number, *far))).collect();
        labels.push([255; 3]);
        let Ok(mixing) = Mixing::new(&labels, false) else { return 0.0 };
        let judged = |((colour, mixture), bin): ((&[f32; 3], &Mixture), &&Bin)| {
            bin.share * (mixing.missed(*colour, mixture) + NOISE * mixing.spread(*colour, mixture))
        };
        colours.iter().zip(&mixtures(&colours, &mixing)).zip(&tried_on).map(judged).sum::<f64>()
    };
    let mut best = judged(&fars);
    for _ in 0..ROUNDS {
        for number in 0..fars.len() {
            for far in OUTWARDS {
                let last = std::mem::replace(&mut fars[number], far);
                let found = if far == last { best } else { judged(&fars) };
                if found < best {
                    best = found;
                } else {
                    fars[number] = last;
                }
            }
        }
    }
    (0..ways.len()).map(|number| ink(number, fars[number])).collect()
}

/// The mean colour by shares.
fn mean<'a>(bins: impl Iterator<Item = &'a Bin>) -> Option<Point> {
    let (sum, share) = bins.fold(([0.0; 3], 0.0), |(sum, share): (Point, f64), bin| {
        (std::array::from_fn(|channel| sum[channel] + bin.share * bin.rgb[channel]), share + bin.share)
    });
    (share > 0.0).then(|| sum.map(|sum| sum / share))
}

fn rounded(rgb: Point) -> [u8; 3] {
    rgb.map(|v| (v * 255.0 + 0.5) as u8)
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn squared(a: Point, b: Point) -> f64 {
    dot(minus(a, b), minus(a, b))
}

/// Björn Ottosson's OKLab of an sRGB colour.
fn oklab(rgb: Point) -> Point {
    let rgb = rgb.map(linear);
    let cones = [
        [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
        [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
        [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
    ];
    let cones = cones.map(|row| libm::cbrt(dot(row, rgb)));
    let axes = [
        [0.210_454_255_3, 0.793_617_785, -0.004_072_046_8],
        [1.977_998_495_1, -2.428_592_205, 0.450_593_709_9],
        [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766],
    ];
    axes.map(|row| dot(row, cones))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::noise;

    fn extracted(colours: &[[f32; 3]], count: usize) -> Vec<[u8; 3]> {
        let fields = [0, 1, 2].map(|channel| {
            let width = colours.len().min(1000);
            Field::new(width, colours.len() / width, colours.iter().map(|colour| colour[channel]).collect()).unwrap()
        });
        extract([&fields[0], &fields[1], &fields[2]], count)
    }

    #[test]
    fn a_photo_of_few_colours_has_those_as_inks() {
        let few = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.2], [0.2, 0.2, 0.8], [1.0, 1.0, 1.0]];
        let photo: Vec<[f32; 3]> = (0..400).map(|k| few[k % 4]).collect();
        assert_eq!(extracted(&photo, 3), [[0, 0, 0], [51, 51, 204], [255, 51, 51]]);
        assert_eq!(extracted(&photo, 10), [[0, 0, 0], [51, 51, 204], [255, 51, 51]]);
        assert_eq!(extracted(&[[1.0; 3]; 9], 4), [[255; 3]]);
    }

    #[test]
    fn inks_go_from_dark_to_light_and_span_the_photo() {
        let random = |k: u64| 0.5 + 0.5 * noise(k);
        let photo: Vec<[f32; 3]> =
            (0..20_000).map(|k| [random(2 * k), 0.2 + 0.3 * random(2 * k + 1), 0.8 - 0.6 * random(2 * k)]).collect();
        let mut missed = Vec::new();
        for count in [1, 2, 4, 8] {
            let inks = extracted(&photo, count);
            assert!(inks.len() == count && inks == extracted(&photo, count));
            let luma = |[r, g, b]: [u8; 3]| 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b);
            assert!(inks.is_sorted_by_key(|ink| luma(*ink)));
            let mixing = Mixing::new(&[&inks[..], &[[255; 3]]].concat(), false).unwrap();
            let all = photo.iter().map(|colour| mixing.missed(*colour, &mixing.of(*colour)));
            missed.push(all.sum::<f64>() / photo.len() as f64);
        }
        assert!(missed.is_sorted_by(|a, b| a > b) && missed[3] < 0.012, "{missed:?}");
    }

    #[test]
    #[ignore = "a measurement"]
    fn time_of_extraction() {
        let random = |k: u64| 0.5 + 0.5 * noise(k);
        let photo: Vec<[f32; 3]> = (0..1_000_000).map(|k| [random(3 * k), random(3 * k + 1), random(3 * k + 2)]).collect();
        for count in [6, 16] {
            let began = std::time::Instant::now();
            let inks = extracted(&photo, count);
            println!("{count}: {:.3} s {inks:?}", began.elapsed().as_secs_f64());
        }
    }
}
