//! The measures of difference, on golden pictures, against what published programs say of them.

use strahl::metrics::{Image8, ciede2000, code_errors, flip};

fn golden(name: &str) -> Image8 {
    let path = format!("{}/tests/golden/{name}.png", env!("CARGO_MANIFEST_DIR"));
    let picture = image::open(path).unwrap().to_rgb8();
    Image8::opaque(picture.width() as usize, picture.pixels().map(|p| p.0).collect())
}

/// Mean, 95 %, 99 %, 99.9 % and largest value of the package flip-evaluator 1.7 on PyPI, which is the authors' own code, in
/// single precision: `evaluate(reference, test, "LDR", applyMagma=False)` with the picture of depth 100 as the reference.
const PUBLISHED: [(&str, [f64; 5]); 2] = [
    ("mirrors-hall-depth-3", [0.185075, 0.684920, 0.826764, 0.901353, 0.968516]),
    ("mirrors-hall-depth-5", [0.095135, 0.561768, 0.615613, 0.748102, 0.792875]),
];

#[test]
fn flip_is_what_its_authors_compute() {
    let reference = golden("mirrors-hall-depth-100");
    for (name, [mean, p95, p99, p999, max]) in PUBLISHED {
        let ours = flip(&reference, &golden(name));
        for (ours, theirs) in [(ours.mean, mean), (ours.p95, p95), (ours.p99, p99), (ours.p999, p999), (ours.max, max)]
        {
            assert!((ours - theirs).abs() < 1e-4, "{name}: {ours} instead of {theirs}");
        }
    }
}

#[test]
fn deeper_pictures_are_nearer_by_every_measure() {
    let reference = golden("mirrors-hall-depth-100");
    let [shallow, deep] = ["mirrors-hall-depth-3", "mirrors-hall-depth-5"].map(golden);
    assert!(flip(&reference, &shallow).mean > flip(&reference, &deep).mean);
    assert!(ciede2000(&reference, &shallow).mean > ciede2000(&reference, &deep).mean);
    let (a, b) = (code_errors(&reference, &shallow), code_errors(&reference, &deep));
    assert!(a.error.mean > b.error.mean && a.identical < b.identical && a.psnr.unwrap() < b.psnr.unwrap());
    assert_eq!(flip(&reference, &reference).max, 0.0);
    assert_eq!(ciede2000(&reference, &reference).max, 0.0);
}
