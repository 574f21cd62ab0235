//! What a picture would save without an effect: more than the effect's share where other rays follow from its own.

use crate::common::{load_scene, on_own_threads};
use strahl::film::Region;
use strahl::plan::Plan;
use strahl::plan::pilot::{Effort, Pilot};
use strahl::render::{Control, render};
use strahl::scene::Overrides;
use strahl::scene::effects::Effect;

#[test]
fn without_glass_more_is_saved_than_the_rays_through_it() {
    on_own_threads(|| {
        let mut loaded = load_scene("whitted/whitted", 320, Overrides::default());
        let (scene, control) = (&loaded.scene, Control::default());
        let region = Region::whole(scene.width, scene.height);
        let mut plan = Plan::new(&mut loaded.description, scene);
        let mut seen = Vec::new();
        // A machine that others use may be slow for a moment, and then it is asked again.
        let tells = (0..5).any(|_| {
            let pilot = plan.estimate(scene, region, &control, Effort::QUICK).unwrap();
            let picture = render(scene, region, &control).unwrap();
            plan.measure(&pilot, &picture.rays, &picture.refined, picture.trace_ms);
            for effect in plan.comparable() {
                plan.compare(effect, scene, region, &control, picture.trace_ms).unwrap();
            }
            let of =
                |effect: Effect| plan.explanation.effects.iter().find(|row| row.kind == effect).unwrap().act.unwrap();
            // Total reflection comes with refraction, and what is off saves nothing.
            assert_eq!((of(Effect::TotalReflection).saves_ms, of(Effect::Fog).saves_ms), (None, None));
            // Glass is nearly all of the time; what its own rays took is half of it.
            let glass = of(Effect::Transmission);
            let (share, saves, all) = (glass.share_ms.unwrap(), glass.saves_ms.unwrap(), picture.trace_ms);
            seen.push((glass, all));
            let saves_more = saves > 0.5 * all && saves > 1.5 * share && saves < all;
            saves_more && of(Effect::Antialiasing).saves_ms > Some(0.0)
        });
        assert!(tells, "{seen:?}");
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
