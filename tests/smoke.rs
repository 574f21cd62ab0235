use strahl::{film, render, scene};
#[test]
fn smoke() {
    for f in std::env::var("SCENES").unwrap().split(',') {
        let d: scene::Description = serde_json::from_slice(&std::fs::read(f).unwrap()).unwrap();
        for (p, prec) in [("s", scene::description::Precision::Single), ("d", scene::description::Precision::Double)] {
            let mut d = d.clone();
            d.render.precision = prec;
            d.render.antialias = false;
            let scene = scene::compile::compile(&d).unwrap_or_else(|e| panic!("{e}"));
            let region = film::Region::whole(scene.width, scene.height);
            let pic = render::render(&scene, region, &render::Control::default()).unwrap();
            println!("{f} {p} {:?} {:.1} ms bvh {:.1}", pic.rays, pic.trace_ms, scene.bvh_ms);
            let name = format!("/tmp/out_{}_{p}.png", std::path::Path::new(f).file_stem().unwrap().to_str().unwrap());
            std::fs::write(name, film::encode(&pic.film, film::FileFormat::Png8)).unwrap();
            let r = strahl::reference::Reference::new(&d);
            let (mut worst, mut bad) = (0.0f64, 0);
            for y in (0..scene.height).step_by(7) {
                for x in (0..scene.width).step_by(7) {
                    let a = pic.film.pixels[(y * scene.width + x) as usize];
                    let b = r.radiance_at(x as f64 + 0.5, y as f64 + 0.5);
                    let e = (0..3).map(|i| (a[i] as f64 - b[i]).abs()).fold(0.0, f64::max);
                    if e > 1e-3 {
                        bad += 1;
                        if bad < 5 {
                            println!("  {x} {y} {a:?} {b:?}");
                        }
                    } else {
                        worst = worst.max(e);
                    }
                }
            }
            println!("  off {bad}, worst of the rest {worst:e}");
        }
    }
}
