//! A made-up photo, with what makes real ones hard or easy for a stippler.
//!
//! A landscape: a light sky with soft clouds, a ridge of dark hills, rough ground that gets coarser towards the viewer, houses
//! with rows of windows, shaded balls that cast shadows, a bush of leaves, a ball that is nearly black and one that is nearly
//! white. So there are smooth gradients, sharp edges, fine and coarse texture, flat darks and lights, and a sensor's noise over all of it.
//!
//! Its shapes keep their places and their share of the picture at every size, as if one scene were taken by cameras of more and more pixels;
//! its textures are value noise whose octaves go on down to two pixels. Only integers, the four operations and square roots are used, so the
//! photo is the same on every machine, whatever the number of threads.

use graphstipple_core::stages::fine_grained;
use graphstipple_core::{Field, Importance, Photo as CorePhoto};

/// What a drawing is made from.
#[derive(Debug, Clone)]
pub struct Photo {
    /// The photo, its values being integers / 255 as in most files.
    pub photo: CorePhoto,
    /// Its fine-grained saliency.
    pub importance: Importance,
}

impl Photo {
    /// Its luma.
    pub fn luma(&self) -> &Field {
        self.photo.luma()
    }
}

/// The photo at a size in pixels, at least 1 x 1.
///
/// # Panics
/// If a side is not one that a [`Field`] may have.
pub fn photo(width: usize, height: usize) -> Photo {
    let scene = Scene::new(width, height);
    let mut luma = Vec::with_capacity(width * height);
    for row in 0..height {
        for column in 0..width {
            luma.push((255.0 * scene.tone(column, row) + 0.5) as u8);
        }
    }
    let importance = Importance::saliency(fine_grained(&luma, width, height));
    let values = luma.iter().map(|v| f32::from(*v) / 255.0).collect();
    let luma = Field::new(width, height, values).expect("8-bit values over 255 are in [0, 1]");
    Photo { photo: CorePhoto::new(luma), importance }
}

/// Where the hills meet the sky and the ground, in heights of the photo.
const HORIZON: f32 = 0.52;

/// Shaded balls on the ground: centre x and y, radius, tone where the light falls on it straight, share of texture.
const BALLS: [[f32; 5]; 6] = [
    [0.22, 0.74, 0.13, 0.95, 0.0],
    [0.50, 0.82, 0.11, 0.60, 0.5],
    [0.40, 0.64, 0.05, 0.12, 0.0],
    [0.74, 0.70, 0.09, 0.80, 0.2],
    [0.62, 0.62, 0.04, 1.60, 0.0],
    [0.90, 0.90, 0.06, 0.45, 0.9],
];

/// Houses: left, right, top, bottom, tone of the wall, columns and rows of windows.
const HOUSES: [[f32; 7]; 3] =
    [[0.55, 0.66, 0.30, 0.60, 0.80, 5.0, 9.0], [0.68, 0.76, 0.40, 0.60, 0.35, 4.0, 5.0], [0.10, 0.17, 0.38, 0.56, 0.65, 3.0, 6.0]];

struct Scene {
    /// One over the photo's width and height in pixels.
    per_pixel: [f32; 2],
    /// Width over height.
    aspect: f32,
    /// Octaves of noise from a quarter of the height down to two pixels.
    octaves: u32,
}

impl Scene {
    fn new(width: usize, height: usize) -> Self {
        Self {
            per_pixel: [1.0 / width as f32, 1.0 / height as f32],
            aspect: width as f32 / height as f32,
            octaves: (height / 8).max(1).ilog2() + 1,
        }
    }

    /// The tone of a pixel, in [0, 1].
    fn tone(&self, column: usize, row: usize) -> f32 {
        // x from 0 to 1 across, y from 0 to 1 down: shapes are placed in these. Noise and circles need `across`, in heights.
        let (x, y) = ((column as f32 + 0.5) * self.per_pixel[0], (row as f32 + 0.5) * self.per_pixel[1]);
        let across = x * self.aspect;
        let [dx, dy] = [x - 0.5, y - 0.5];
        let vignette = 1.0 - 0.35 * (dx * dx + dy * dy);
        let sensor = 0.03 * (hash(7, column as i32, row as i32) - 0.5);
        // A little more contrast than there is room for, as cameras give: the darkest and the lightest parts become flat.
        (1.12 * (self.front(x, y, across) * vignette - 0.5) + 0.5 + sensor).clamp(0.0, 1.0)
    }

    /// The tone of what is in front at a place.
    fn front(&self, x: f32, y: f32, across: f32) -> f32 {
        let leaves = self.fractal(1, 2.0 * across, 2.0 * y, self.octaves);
        // A bush in the lower left corner: leaves where the noise is high, thinning out away from the corner.
        let bush = leaves - 0.35 - 0.6 * (x + (1.0 - y));
        if bush > 0.0 {
            return (0.05 + 2.5 * bush * leaves).min(0.7);
        }
        for ball in BALLS {
            if let Some(tone) = self.ball(ball, across, y, leaves) {
                return tone;
            }
        }
        for house in HOUSES {
            if let Some(tone) = house_tone(house, x, y) {
                return tone;
            }
        }
        let ridge = HORIZON - 0.22 * self.fractal(2, 1.5 * across, 0.0, 4);
        if y < ridge {
            let cloud = (2.0 * self.fractal(3, 0.7 * across, 1.6 * y, 5) - 0.8).clamp(0.0, 1.0);
            return 0.95 - 0.35 * (ridge - y) + 0.25 * cloud * cloud;
        }
        if y < HORIZON {
            return 0.10 + 0.35 * leaves * leaves;
        }
        // Ground: the noise is stretched towards the viewer.
        let near = (y - HORIZON) / (1.0 - HORIZON);
        let ground = 0.25 + 0.3 * near + 0.9 * (self.fractal(4, 3.0 * across / (0.3 + near), 6.0 * near, self.octaves) - 0.5);
        ground * self.light(across, y)
    }

    /// A ball's tone, if the place is on it.
    fn ball(&self, [x, y, radius, lit, texture]: [f32; 5], across: f32, down: f32, noise: f32) -> Option<f32> {
        let (dx, dy) = ((across - x * self.aspect) / radius, (down - y) / radius);
        let away = dx * dx + dy * dy;
        if away > 1.0 {
            return None;
        }
        // Light from the upper left, in front of the picture.
        let facing = (-0.5 * dx - 0.6 * dy + 0.62 * (1.0 - away).sqrt()).max(0.0);
        Some(lit * (0.08 + 0.92 * facing) * (1.0 - texture + texture * 1.6 * noise))
    }

    /// How much light the balls' shadows leave on the ground, in [0, 1]: a third in their middle, soft at their rims.
    fn light(&self, across: f32, y: f32) -> f32 {
        let mut light = 1.0;
        for [ball_x, ball_y, radius, ..] in BALLS {
            let dx = (across - ball_x * self.aspect - 0.8 * radius) / (1.5 * radius);
            let dy = (y - ball_y - 0.85 * radius) / (0.35 * radius);
            light *= (0.3 + 2.0 * (dx * dx + dy * dy - 0.6)).clamp(0.3, 1.0);
        }
        light
    }

    /// Value noise in [0, 1] over `octaves` octaves, the coarsest with a wavelength of a quarter of the unit.
    fn fractal(&self, seed: u32, x: f32, y: f32, octaves: u32) -> f32 {
        let (mut frequency, mut amplitude) = (4.0, 1.0);
        let (mut sum, mut total) = (0.0, 0.0);
        for octave in 0..octaves {
            sum += amplitude * noise(seed * 64 + octave, x * frequency, y * frequency);
            total += amplitude;
            frequency *= 2.0;
            // Slower than one half, or nothing would be left of the finest octaves.
            amplitude *= 0.68;
        }
        sum / total
    }
}

/// A house's tone, if the place is on it.
fn house_tone([left, right, top, bottom, wall, columns, rows]: [f32; 7], x: f32, y: f32) -> Option<f32> {
    if x < left || x > right || y < top || y > bottom {
        return None;
    }
    let (column, row) = ((x - left) / (right - left) * columns, (y - top) / (bottom - top) * rows);
    let (in_column, in_row) = (column - column.floor(), row - row.floor());
    let is_window = (0.25..0.75).contains(&in_column) && (0.2..0.7).contains(&in_row);
    // Some windows are lit, the others dark.
    let window = if hash(11, column as i32, row as i32) > 0.7 { 0.98 } else { 0.06 };
    Some(if is_window { window } else { wall })
}

/// Smooth noise in [0, 1]: random values on the integer grid, interpolated.
fn noise(seed: u32, x: f32, y: f32) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (smooth(x - column), smooth(y - row));
    let (column, row) = (column as i32, row as i32);
    let along = |row: i32| {
        let (a, b) = (hash(seed, column, row), hash(seed, column + 1, row));
        a + tx * (b - a)
    };
    let (above, below) = (along(row), along(row + 1));
    above + ty * (below - above)
}

/// A number in [0, 1) that looks random and depends on the arguments alone.
fn hash(seed: u32, x: i32, y: i32) -> f32 {
    let mut h = seed.wrapping_mul(0x9E37_79B1) ^ (x as u32).wrapping_mul(0x85EB_CA77) ^ (y as u32).wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    h ^= h >> 15;
    (h >> 8) as f32 / (1u32 << 24) as f32
}
