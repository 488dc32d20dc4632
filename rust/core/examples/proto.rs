//! proto
use graphstipple_core::{importance::Importance, *};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (w, h): (usize, usize) = (a[1].parse().unwrap(), a[2].parse().unwrap());
    let rd = |p: &str| {
        let b = std::fs::read(p).unwrap();
        Field::new(w, h, b.iter().map(|v| *v as f32 / 255.0).collect()).unwrap()
    };
    let luma = rd(&a[3]);
    let imp = if a[4] == "none" { Importance::Constant(1.0) } else { Importance::Saliency(rd(&a[4])) };
    let options: Options = serde_json::from_str(&a[5]).unwrap();
    let out = draw(&luma, &imp, &options, &Control::new()).unwrap();
    println!("{}", serde_json::to_string(&out.stats).unwrap());
    let d = &out.drawing;
    let total: f64 = (0..d.regions.len()).map(|i| d.region_area(i)).sum::<f64>()
        + (0..d.stipples.len()).map(|i| drawing::signed_area(&d.stipple_outline(i, 0.05))).sum::<f64>();
    println!("area {total} of {}", w * h);
    // crude svg
    let mut s = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='{w}' height='{h}' viewBox='0 0 {w} {h}'><rect width='{w}' height='{h}' fill='#fff'/>"
    );
    for l in d.levels() {
        let mut p = String::new();
        for m in &l.marks {
            match *m {
                drawing::Mark::Region(i) => p += &d.ring_path(&d.regions[i as usize].exterior, 0.05).to_svg(),
                drawing::Mark::Stipple(i) => {
                    for (k, q) in d.stipple_outline(i as usize, 0.02).iter().enumerate() {
                        p += &format!("{}{:.3} {:.3}", if k == 0 { "M" } else { "L" }, q[0], q[1]);
                    }
                    p += "Z";
                }
            }
        }
        s += &format!("<path fill='{}' d='{}'/>", if l.ink == drawing::Ink::Black { "#000" } else { "#fff" }, p);
    }
    std::fs::write(&a[6], s + "</svg>").unwrap();
}
