//! What a picture would save without an effect, and the rays of one without it.

use crate::common::{load_scene, on_own_threads};
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::pilot::{Effort, Pilot};
use strahl::render::{Control, render};
use strahl::scene::Overrides;
use strahl::scene::effects::Effect;

#[test]
fn what_is_on_has_savings_and_what_is_off_has_none() {
    on_own_threads(|| {
        let mut loaded = load_scene("whitted/whitted", 64, Overrides::default());
        let (scene, control) = (&loaded.scene, Control::default());
        let region = Region::whole(scene.width, scene.height);
        let mut plan = Plan::new(&mut loaded.description, scene);
        let pilot = plan.estimate(scene, region, &control, Effort::QUICK).unwrap();
        let picture = render(scene, region, &control).unwrap();
        plan.measure(&pilot, &picture.rays, &picture.refined, picture.trace_ms);
        for effect in plan.comparable() {
            plan.compare(effect, scene, region, &control, picture.trace_ms).unwrap();
        }
        let saves = |effect: Effect| {
            let row = plan.explanation.effects.iter().find(|row| row.kind == effect).unwrap();
            row.act.unwrap().saves_ms.map(|saves| saves.is_finite() && saves <= picture.trace_ms)
        };
        assert_eq!([Effect::Transmission, Effect::Antialiasing].map(saves), [Some(true); 2]);
        // Total reflection comes with refraction, and what is off saves nothing.
        assert_eq!([Effect::TotalReflection, Effect::Fog].map(saves), [None; 2]);
    });
}

#[test]
fn a_pilot_without_an_effect_has_the_rays_of_the_picture_without_it() {
    on_own_threads(|| {
        let loaded = load_scene("whitted/whitted", 64, Overrides { antialias: Some(false), ..Overrides::default() });
        let (control, region) = (Control::default(), Region::whole(loaded.scene.width, loaded.scene.height));
        for effect in [Effect::Transmission, Effect::Reflection, Effect::Shadows, Effect::CheckerTexture] {
            let scene = loaded.scene.without(effect).unwrap();
            // So few pixels are all traced.
            let all = Effort { time: std::time::Duration::from_secs(60), share: f64::INFINITY };
            let pilot = Pilot::run(&scene, region, &control, all).unwrap();
            let rays = render(&scene, region, &control).unwrap().rays;
            let [_, shadow, reflected, transmitted, _] = pilot.kinds.map(|kind| kind.value as u64);
            assert_eq!([shadow, reflected, transmitted], [rays.shadow, rays.reflected, rays.transmitted], "{effect:?}");
            assert!(match effect {
                Effect::Transmission => transmitted == 0,
                // What is reflected totally is left.
                Effect::Reflection => reflected == rays.total_internal_reflections,
                Effect::Shadows => shadow == 0,
                _ => rays.total() > 0,
            });
        }
    });
}

#[test]
fn repeated_diffuse_light_is_not_simulated_unless_rays_bring_it() {
    let lacks = |name: &str| {
        let mut loaded = load_scene(name, 16, Overrides::default());
        let plan = Plan::new(&mut loaded.description, &loaded.scene);
        plan.explanation.not_simulated.contains(&"repeated_diffuse_interreflection")
    };
    assert_eq!(["effects/color_bleeding", "effects/global_illumination"].map(lacks), [true, false]);
}
