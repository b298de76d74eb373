use std::time::Instant;
use pelage::tracer::Settings;
use pelage_tests::stage::{Content, Shot, bent, coat, flat, judge, suns};
use pelage_tests::texel;

#[test]
fn try_it() {
    for content in Content::ALL {
        let start = Instant::now();
        let t = texel(&content.geometry(), 6, true);
        println!("{content:?} built {:.1}", start.elapsed().as_secs_f32());
        for (n, skin) in [("flat", flat()), ("bent", bent())] {
            println!("{:?}", skin.report.left_out());
            let mut scene = coat(skin, t.clone());
            for w in [64.0, 16.0, 4.0, 1.0] {
                let start = Instant::now();
                let shot = Shot::new(35.0, w, 40);
                let o = judge(&mut scene, &shot, &suns(35.0), &Settings::default(), if w > 2.0 {32} else {256});
                print!("{content:?} {n} {w}: alpha {:.4}", o[0].alpha);
                for o in o { print!(" {:.3} ({:+.3})", o.energy, o.excess); }
                println!(" {:.1} s", start.elapsed().as_secs_f32());
            }
        }
    }
}
