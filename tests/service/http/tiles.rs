//! Deep zoom: tiles are crops of whole levels, by each convention, and levels go beyond the picture's own size.

use crate::common::service::{Answer, Service};
use image::{DynamicImage, GenericImage, GenericImageView, RgbImage};

/// Edges everywhere, so that antialiasing has something to do at the borders of tiles.
const SCENE: &str = r#"{
  "version": 1,
  "image": { "width": 1201, "height": 700 },
  "camera": { "pinhole": { "eye": [0, 2, 6], "look_at": [0, 0.5, 0] } },
  "background": [0.3, 0.5, 0.8],
  "materials": {
    "glass": { "diffuse": 0.1, "reflection": 0.2, "transmission": 0.7, "ior": 1.5 },
    "floor": { "diffuse": { "checker": { "a": 0.9, "b": 0.1, "size": 0.5 } } }
  },
  "objects": [
    { "sphere": { "center": [0, 1, 0], "radius": 1, "material": "glass" } },
    { "plane": { "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" } }
  ]
}"#;

fn open(service: &Service, path: &str) -> String {
    let answer = service.post_json(path, SCENE);
    assert_eq!(answer.status, 201, "{}", answer.text());
    answer.json()["image_id"].as_str().unwrap().to_owned()
}

fn picture(service: &Service, path: &str) -> RgbImage {
    let answer = service.get(path);
    assert_eq!(answer.status, 200, "{path}: {}", answer.text());
    image::load_from_memory(&answer.body).unwrap_or_else(|error| panic!("{path}: {error}")).to_rgb8()
}

/// The scene in a picture of some size, rendered at once.
fn whole(service: &Service, width: u32, height: u32) -> DynamicImage {
    service.post_json(&format!("/v1/render?width={width}&height={height}"), SCENE).picture()
}

#[test]
fn dzi_tiles_are_crops_of_their_level() {
    let service = Service::start(&[]);
    let id = open(&service, "/v1/scenes");
    let about = service.get(&format!("/dzi/{id}.dzi"));
    assert_eq!(about.header("content-type"), "application/xml");
    assert!(about.text().contains(r#"<Size Width="1201" Height="700"/>"#), "{}", about.text());
    assert!(about.text().contains(r#"Format="png" Overlap="0" TileSize="512""#), "{}", about.text());
    assert!(service.get(&format!("/dzi/{id}.dzi?format=webp")).text().contains(r#"Format="webp""#));

    // 2^11 is the first power of two that holds the picture.
    let mut stitched = RgbImage::new(1_201, 700);
    for (column, row) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
        let tile = picture(&service, &format!("/dzi/{id}_files/11/{column}_{row}.png"));
        stitched.copy_from(&tile, 512 * column, 512 * row).unwrap();
    }
    assert_eq!(stitched, whole(&service, 1_201, 700).to_rgb8(), "the tiles are the picture");
    let half = picture(&service, &format!("/iiif/3/{id}/full/601,350/0/default.png"));
    let left = picture(&service, &format!("/dzi/{id}_files/10/0_0.webp"));
    let right = picture(&service, &format!("/dzi/{id}_files/10/1_0.png"));
    assert_eq!((left.dimensions(), right.dimensions()), ((512, 350), (89, 350)));
    assert_eq!(left, half.view(0, 0, 512, 350).to_image());
    assert_eq!(right, half.view(512, 0, 89, 350).to_image());
    assert_eq!(picture(&service, &format!("/dzi/{id}_files/0/0_0.png")).dimensions(), (1, 1));
    for missing in ["12/0_0.png", "11/3_0.png", "11/0_2.png", "11/0_0.exr", "11/-1_0.png", "x/0_0.png", "11/00.png"] {
        service.get(&format!("/dzi/{id}_files/{missing}")).problem(404, "not-found");
    }
}

/// Tiles of 512 x 512 pixels would be more samples than an answer may have.
#[test]
fn tiles_with_many_samples_are_smaller_ones() {
    let service = Service::start(&["--max-samples-total", "1000000"]);
    let id = open(&service, "/v1/scenes?samples=16&width=300&height=200");
    let info = service.get(&format!("/iiif/3/{id}/info.json")).json();
    assert_eq!(info["tiles"][0]["width"], 128, "{info}");
    for factor in info["tiles"][0]["scaleFactors"].as_array().unwrap() {
        let edge = 128 * factor.as_u64().unwrap();
        let (wide, tall) = (edge.min(300), edge.min(200));
        let [width, height] = [wide, tall].map(|side| side.div_ceil(factor.as_u64().unwrap()));
        let tile = picture(&service, &format!("/iiif/3/{id}/0,0,{wide},{tall}/{width},{height}/0/default.png"));
        assert_eq!((u64::from(tile.width()), u64::from(tile.height())), (width, height));
    }
    assert!(service.get(&format!("/dzi/{id}.dzi")).text().contains(r#"TileSize="128""#));
    let last = picture(&service, &format!("/dzi/{id}_files/9/2_1.png"));
    assert_eq!(last.dimensions(), (300 - 256, 200 - 128));
    let about = service.get(&format!("/xyz/{id}.json")).json();
    assert_eq!((&about["tileSize"], &about["nativezoom"]), (&128.into(), &2.into()));
    assert_eq!(picture(&service, &format!("/xyz/{id}/2/2/1.png")).dimensions(), (128, 128));
    service.get(&format!("/xyz/{id}/2/3/0.png")).problem(404, "not-found");
}

#[test]
fn xyz_tiles_are_whole_and_deeper_zooms_show_more() {
    let service = Service::start(&[]);
    let id = open(&service, "/v1/scenes");
    let about = service.get(&format!("/xyz/{id}.json")).json();
    assert_eq!((&about["width"], &about["nativezoom"], &about["tileSize"]), (&1_201.into(), &2.into(), &512.into()));
    let native = whole(&service, 1_201, 700).to_rgb8();
    let tile = picture(&service, &format!("/xyz/{id}/2/1/0.png"));
    assert_eq!(tile, native.view(512, 0, 512, 512).to_image());
    assert_eq!(picture(&service, &format!("/xyz/{id}/2/2/1.png")).dimensions(), (512, 512), "also at the edge");

    // One zoom deeper is the picture of twice the size, ray by ray.
    let double = whole(&service, 2_402, 1_400).to_rgb8();
    assert_eq!(picture(&service, &format!("/xyz/{id}/3/2/1.png")), double.view(1_024, 512, 512, 512).to_image());
    let deepest = about["maxzoom"].as_u64().unwrap();
    assert!(deepest > 6, "{about}");
    assert_eq!(service.get(&format!("/xyz/{id}/{deepest}/7/7.png")).status, 200);
    for missing in [format!("{}/0/0.png", deepest + 1), "2/3/0.png".into(), "0/0/0.pfm".into(), "99999/0/0.png".into()]
    {
        service.get(&format!("/xyz/{id}/{missing}")).problem(404, "not-found");
    }
}

#[test]
fn a_scene_can_be_opened_larger_than_its_picture() {
    let service = Service::start(&[]);
    let id = open(&service, "/v1/scenes?zoom=1");
    let info = service.get(&format!("/iiif/3/{id}/info.json")).json();
    assert_eq!((&info["width"], &info["height"]), (&2_402.into(), &1_400.into()));
    let double = whole(&service, 2_402, 1_400).to_rgb8();
    let part = picture(&service, &format!("/iiif/3/{id}/300,200,400,300/max/0/default.png"));
    assert_eq!(part, double.view(300, 200, 400, 300).to_image());
    assert_eq!(picture(&service, &format!("/v1/images/{id}.png")), double);
    service.post_json("/v1/scenes?zoom=16", SCENE).problem(400, "invalid-parameter");
    service.post_json("/v1/scenes?zoom=17", SCENE).problem(400, "invalid-parameter");
    let far = service.post_json("/v1/scenes?zoom=16&precision=double", SCENE).json();
    let id = far["image_id"].as_str().unwrap();
    assert_eq!(far["width"], 1_201 << 16);
    assert_eq!(
        picture(&service, &format!("/iiif/3/{id}/40000000,20000000,64,64/max/0/default.png")).dimensions(),
        (64, 64)
    );
}

#[test]
fn iiif_says_what_it_can_and_shows_it() {
    let service = Service::start(&["--cors-origin", "*"]);
    let id = open(&service, "/v1/scenes");
    let base = format!("/iiif/3/{id}");
    let led = service.get(&base);
    assert_eq!((led.status, led.header("location")), (303, format!("http://localhost{base}/info.json").as_str()));
    let info = service.get(&format!("{base}/info.json"));
    assert!(info.header("content-type").starts_with("application/ld+json;profile="), "{:?}", info.headers);
    assert_eq!(info.header("access-control-allow-origin"), "*");
    let plain = service.send("GET", &format!("{base}/info.json"), &[("Accept", "*/*")], b"");
    assert_eq!(plain.header("content-type"), "application/json");
    let info = info.json();
    assert_eq!((&info["profile"], &info["type"]), (&"level2".into(), &"ImageService3".into()));
    assert_eq!(info["id"], format!("http://localhost{base}"));
    assert_eq!(info["tiles"][0]["scaleFactors"], serde_json::json!([1, 2, 4]));
    assert_eq!(info["sizes"][0], serde_json::json!({ "type": "Size", "width": 301, "height": 175 }));
    let public = Service::start(&["--public-url", "https://render.example.org/"]);
    let id = open(&public, "/v1/scenes");
    let info = public.get(&format!("{base}/info.json")).json();
    assert_eq!(info["id"], format!("https://render.example.org/iiif/3/{id}"));

    let whole = whole(&service, 1_201, 700).to_rgb8();
    let get = |path: &str| picture(&service, &format!("{base}/{path}"));
    assert_eq!(get("full/max/0/default.png"), whole);
    assert_eq!(get("full/max/0/default.webp"), whole);
    let part = whole.view(100, 50, 300, 200).to_image();
    assert_eq!(get("100,50,300,200/max/0/color.png"), part);
    assert_eq!(get("100,50,300,200/max/90/default.png"), image::imageops::rotate90(&part));
    assert_eq!(get("100,50,300,200/max/90.0/default.png"), image::imageops::rotate90(&part));
    assert_eq!(get("100,50,300,200/max/360/default.png"), part);
    assert_eq!(get("100,50,300,200/max/!0/default.png"), image::imageops::flip_horizontal(&part));
    assert_eq!(get("1000,600,900,900/max/0/default.png").dimensions(), (201, 100), "cut off at the edges");
    assert_eq!(get("square/100,/0/default.jpg").dimensions(), (100, 100));
    assert!(get("0,0,99,99/33,/0/gray.png").pixels().all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2]));
    assert!(get("0,0,99,99/33,/0/bitonal.png").pixels().all(|pixel| matches!(pixel.0, [0, 0, 0] | [255, 255, 255])));
    let answer: Answer = service.get(&format!("{base}/0,0,512,512/256,/0/color.png"));
    let link = answer.header("link");
    assert!(
        link.contains(&format!("<http://localhost{base}/0,0,512,512/256,256/0/default.png>;rel=\"canonical\"")),
        "{link}"
    );
    assert!(link.contains("level2.json>;rel=\"profile\""), "{link}");
    for wrong in
        ["0,0,0,0/max/0/default.png", "full/5000,/0/default.png", "full/max/45/default.png", "full/max/0/default.gif"]
    {
        service.get(&format!("{base}/{wrong}")).problem(400, "bad-iiif-request");
    }
    service.get("/iiif/3/nobody/info.json").problem(404, "not-found");
}
