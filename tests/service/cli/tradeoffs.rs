//! `strahl tradeoff`.

use super::{done, fails, folder, strahl};
use serde_json::Value;

#[test]
fn a_tradeoff_is_a_page_and_numbers() {
    let folder = folder("tradeoff");
    let args = ["tradeoff", "ball.json", "-o", "t.html", "--json", "t.json", "--seconds", "60"];
    let output = strahl(&folder, &args, "");
    let said = String::from_utf8(output.stderr).unwrap();
    let t: Value = serde_json::from_slice(&std::fs::read(folder.join("t.json")).unwrap()).unwrap();
    let answer = t["choices"]["answer"].as_str().unwrap();
    assert!(output.status.success() && said.lines().any(|line| line == answer), "{answer} in {said}");
    let choices = t["choices"]["all"].as_array().unwrap();
    assert!(choices.iter().any(|choice| choice["name"] == "proved:1") && choices.len() <= 11, "{choices:?}");
    let times: Vec<f64> = choices.iter().map(|choice| choice["request_ms"].as_f64().unwrap()).collect();
    let least = t["choices"]["load_ms"].as_f64().unwrap() + t["choices"]["encode_ms"].as_f64().unwrap();
    assert!(times.is_sorted() && times[0] > least, "{choices:?}");
    let points = t["points"].as_array().unwrap();
    assert!(points.len() >= 24, "{}", points.len());
    for point in points {
        assert!(point["time"]["median_ms"].as_f64() >= point["time"]["min_ms"].as_f64(), "{point}");
        assert!(point["rays"]["camera"].as_u64() >= Some(1200), "{point}");
        // In double precision nothing but the end of the recursion makes a difference.
        let (proved, measured) = (&point["proved_codes"], &point["measured"]["truncation"]["codes"]["error"]["max"]);
        if point["settings"]["precision"] == "double" {
            assert!(proved.is_u64() && measured.as_f64() <= proved.as_f64(), "{point}");
        }
        for source in ["truncation", "sampling", "total"] {
            let error = &point["measured"][source];
            for measure in ["/codes/error/max", "/codes/error/p999", "/codes/identical", "/flip/p99", "/ciede2000/mean"]
            {
                assert!(error.pointer(measure).is_some_and(Value::is_number), "{measure} in {source} of {point}");
            }
        }
    }
    assert_eq!(t["fronts"].as_array().map(Vec::len), Some(4), "{t}");
    assert!(t["advice"].as_array().is_some_and(|advice| !advice.is_empty()), "{t}");
    assert_eq!(t["circumstances"]["asked_size"], t["circumstances"]["size"], "so small a picture is not scaled down");

    let page = std::fs::read_to_string(folder.join("t.html")).unwrap();
    // What one needs to choose comes before anything folds out: the answer, pictures and a plot, for broad and slim screens.
    let (first, rest) = page.split_once("<details>").unwrap();
    let shown = first.matches("data:image/png;base64,").count();
    assert!(first.contains(&format!("<p class=\"answer\">{answer}</p>")) && (1..=3).contains(&shown), "{first}");
    for word in ["knee", "front"] {
        assert!(!page.contains(&format!(" {word} ")), "{word}");
    }
    assert_eq!((first.matches("<svg").count(), rest.matches("<svg").count()), (2, 4));
    assert_eq!(rest.matches("data:image/png;base64,").count(), 3 * points.len());
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    for word in ["http:", "https:", "<script"] {
        assert!(!outside.contains(word), "{word}");
    }
    done(&folder, &["tradeoff", "ball.json", "-o", "t.svg", "--seconds", "1"], "");
    let drawing = std::fs::read_to_string(folder.join("t.svg")).unwrap();
    assert!(drawing.starts_with("<svg") && !drawing.contains("NaN") && !drawing.contains("inf"), "{drawing}");
    fails(&folder, &["tradeoff", "ball.json", "-o", "t.png"], "", 2, ".html");
}

#[test]
fn settings_that_are_those_of_the_reference_have_no_error() {
    let folder = folder("tradeoff-exact");
    let settings = [
        "--max-depth",
        "1000",
        "--min-weight",
        "0",
        "--samples",
        "64",
        "--precision",
        "double",
        "--antialias",
        "false",
    ];
    let args = [&["tradeoff", "ball.json", "-o", "-", "--json", "t.json", "--seconds", "60"], &settings[..]].concat();
    done(&folder, &args, "");
    let t: Value = serde_json::from_slice(&std::fs::read(folder.join("t.json")).unwrap()).unwrap();
    assert_eq!(t["reference"]["min_weight"], 0.0, "{}", t["reference"]);
    let asked = t["points"].as_array().unwrap().iter().find(|p| p["sweeps"][0] == "as_asked").unwrap();
    for source in ["truncation", "sampling", "total"] {
        let error = &asked["measured"][source];
        assert_eq!(
            (&error["codes"]["error"]["max"], &error["codes"]["identical"]),
            (&0.0.into(), &1.0.into()),
            "{asked}"
        );
        assert_eq!((&error["flip"]["max"], &error["rms_codes"]), (&0.0.into(), &0.0.into()), "{asked}");
    }
}
