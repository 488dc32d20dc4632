//! Every stage at one megapixel, each on what the stages before it made; see the crate's text for how to read the times.

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use graphstipple_bench::stages::Prepared;
use graphstipple_bench::{is_smoke_run, options, photo};

fn stages(criterion: &mut Criterion) {
    let (width, height) = if is_smoke_run() { (96, 72) } else { (1024, 768) };
    let prepared = Prepared::new(photo(width, height), options()).expect("the photo can be drawn");
    println!("{}, {} threads", prepared.summary(), rayon::current_num_threads());

    let mut group = criterion.benchmark_group("stages");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(4));
    for stage in prepared.stages() {
        group.bench_function(stage.name, |bencher| bencher.iter_custom(|calls| (0..calls).map(|_| stage.time()).sum()));
    }
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
