//! vor
use graphstipple_core::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: u64 = a[1].parse().unwrap();
    let lat = lattice::Lattice::new(LatticeKind::Hexagonal, 512, 512, 1.0).unwrap();
    let mut s = 1u64;
    let sites: Vec<[f64; 2]> = lat
        .sites()
        .into_iter()
        .filter(|p| {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 33) % 100 < (20.0 + 20.0 * (p[0] / 40.0).sin()) as u64
        })
        .collect();
    let f = Field::constant(512, 512, 0.5).unwrap();
    for _ in 0..n {
        let t = std::time::Instant::now();
        let c = voronoi::cells(&sites, 512, 512, 2, Some(&f), &Control::new()).unwrap();
        let t1 = t.elapsed();
        let t = std::time::Instant::now();
        let tr = triangulation::triangulate(sites.clone(), 512, 512, &Control::new()).unwrap();
        eprintln!("sites {} cells {:?} tri {:?} {} {}", sites.len(), t1, t.elapsed(), c.counts[5], tr.graph.neighbors.len());
    }
}
