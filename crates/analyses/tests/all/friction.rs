//! Friction that differs over the interface, that follows from the strength of asperities, and on closed-form rough surfaces.
#![allow(clippy::unwrap_used, clippy::print_stdout)]
use analyses::{Error, Run, run};
use brake_reuss_beam::BrakeReussBenchmark;
use contact_laws::{
    ContactCurves, ElasticPair, GreenwoodWilliamsonCurves, GreenwoodWilliamsonSurface, HeightDistribution,
    TangentialReading,
};
use joints::Options;
use joints::progress::Silent;
use scenes::Scene;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::OnceLock;

/// Reduced models that several tests use, in a folder of this process.
fn cache() -> &'static PathBuf {
    static CACHE: OnceLock<PathBuf> = OnceLock::new();
    CACHE.get_or_init(|| std::env::temp_dir().join(format!("analyses-friction-{}", std::process::id())))
}

/// Writes fields into a block, those of blocks within it one by one; `null` takes a field away.
fn merge(block: &mut Value, fields: &Value) {
    let Some(fields) = fields.as_object() else {
        *block = fields.clone();
        return;
    };
    for (name, value) in fields {
        if value.is_null() {
            block.as_object_mut().unwrap().remove(name);
        } else {
            merge(&mut block[name], value);
        }
    }
}

/// A scene on the benchmark's quick mesh with some fields more.
fn scene(fields: &Value) -> Result<Scene, scenes::Error> {
    let mut scene = json!({
        "units": { "length": "m", "mass": "kg", "time": "s" },
        "structure": { "benchmark": "brake-reuss-beam" },
        "model": { "element_order": "linear", "refinement": "quick" },
        "interfaces": {
            "surface": { "parameters": { "per": "interface", "sets": [
                { "curves": { "elastic": { "normal_stiffness": 5e13, "tangential_stiffness": [3e13, 3e13] } } },
            ] } },
            "mu": 0.1,
            "points_per_direction": 2,
        },
        "analyses": { "backbone": { "amplitudes": 3, "amplitude_from": 1e-5, "amplitude_to": 1e-4 } },
    });
    merge(&mut scene, fields);
    Scene::from_json(&scene.to_string(), "scene.json", "friction", &[&BrakeReussBenchmark])
}

fn go(scene: &Scene) -> Result<Run, Error> {
    let run = run(scene, &Options::cached(cache()), &Silent)?;
    run.checkpoints.remove();
    Ok(run)
}

/// Angular frequency and damping of CQSMA and of all other methods.
fn curves(run: &Run) -> Vec<[f64; 2]> {
    let own = run.amplitudes().iter().map(|amplitude| {
        let found = amplitude.point.result.as_ref().unwrap();
        [found.omega, found.zeta]
    });
    let others = run.first().methods.iter().flat_map(|method| &method.points);
    let others = others.map(|point| {
        let found = point.result.as_ref().unwrap();
        [found.omega, found.zeta.unwrap_or(0.0)]
    });
    own.chain(others).collect()
}

/// All methods see the friction coefficient of the points: from the sets, and from zones.
#[test]
fn coefficients_of_sets_and_zones_are_those_of_a_uniform_interface() {
    let set = |mu: f64| {
        json!({ "parameters": { "per": "interface", "sets": [
            { "mu": mu, "curves": { "elastic": { "normal_stiffness": 5e13, "tangential_stiffness": [3e13, 3e13] } } },
        ] } })
    };
    let zone = json!([{ "mu": 0.03, "x": [-1.0, 1.0], "y": [-1.0, 1.0] }]);
    let found = |interfaces: Value| {
        let fields = json!({ "interfaces": interfaces, "analyses": { "backbone": { "methods": ["qsma"] } } });
        curves(&go(&scene(&fields).unwrap()).unwrap())
    };
    let uniform = found(json!({ "mu": 0.03 }));
    let of_set = found(json!({ "surface": set(0.03) }));
    let of_zone = found(json!({ "friction_zones": zone }));
    assert_eq!(uniform, of_set);
    assert_eq!(uniform, of_zone);
    // And it matters.
    let rougher = found(json!({}));
    let both = uniform.iter().zip(&rougher);
    assert!(
        both.clone().all(|(a, b)| a[0] <= b[0]) && both.clone().any(|(a, b)| a[0] < 0.99 * b[0]),
        "{uniform:?} {rougher:?}"
    );
    // A part of the interface lies between.
    let half = json!([{ "mu": 0.03, "x": [-1.0, 0.0], "y": [-1.0, 1.0] }]);
    let half = found(json!({ "friction_zones": half }));
    for ((low, between), high) in uniform.iter().zip(&half).zip(&rougher) {
        assert!(
            low[0] <= between[0] && between[0] <= high[0],
            "{low:?} {between:?} {high:?}"
        );
    }
}

#[test]
fn zones_that_do_not_fit_are_refused() {
    let refused = |zones: Value, more: Value| {
        let mut fields = more;
        fields["interfaces"]["friction_zones"] = zones;
        match scene(&fields).map_err(Error::from).and_then(|scene| go(&scene)) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("accepted"),
        }
    };
    let zone = |mu: f64, x: [f64; 2]| json!({ "mu": mu, "x": x, "y": [-1.0, 1.0] });
    let beside = refused(json!([zone(0.3, [1.0, 2.0])]), json!({}));
    assert!(
        beside.contains("interfaces.friction_zones, number 1") && beside.contains("no quadrature point"),
        "{beside}"
    );
    let twice = refused(json!([zone(0.3, [-1.0, 0.0]), zone(0.4, [-0.01, 1.0])]), json!({}));
    assert!(twice.contains("number 2") && twice.contains("number 1 too"), "{twice}");
    let negative = refused(json!([zone(-0.3, [-1.0, 1.0])]), json!({}));
    assert!(negative.contains("interfaces.friction_zones[].mu"), "{negative}");
    let turned = refused(json!([zone(0.3, [1.0, -1.0])]), json!({}));
    assert!(turned.contains("interfaces.friction_zones[].x"), "{turned}");
    let half = json!({ "model": { "refinement": "quick", "symmetry": "half" } });
    let mirrored = refused(json!([zone(0.3, [-1.0, 1.0])]), half);
    assert!(mirrored.contains("interfaces.friction_zones"), "{mirrored}");
}

/// The traction at the reported closure is the mean pressure, as the library has it.
#[test]
fn greenwood_williamson_in_a_scene_is_that_of_the_library() {
    for (heights, distribution) in [
        (
            json!({ "gaussian": "3 um" }),
            HeightDistribution::Gaussian {
                standard_deviation: 3e-6,
            },
        ),
        (
            json!({ "exponential": 2e-6 }),
            HeightDistribution::Exponential { scale: 2e-6 },
        ),
    ] {
        let rough = json!({ "parameters": { "per": "interface", "sets": [ { "curves": { "greenwood-williamson": {
            "heights": heights, "reference_height": "12 um", "asperity_density": "1.4 1/mm^2",
            "radii": ["1.2 mm", "1.6 mm"],
        } } } ] } });
        let scene = scene(&json!({ "interfaces": { "surface": rough } })).unwrap();
        let found = go(&scene).unwrap();
        let law = found.law();
        assert_eq!(law.kind, "greenwood-williamson");
        let surface = GreenwoodWilliamsonSurface {
            heights: distribution,
            reference_height: 12e-6,
            asperity_density: 1.4e6,
            radii: [1.2e-3, 1.6e-3],
        };
        let material = scene.model.material.unwrap();
        let material = ElasticPair::new(material.youngs_modulus.si(), material.poisson_ratio);
        let curves = GreenwoodWilliamsonCurves::try_new(surface, material, TangentialReading::Mindlin).unwrap();
        let (pressure, _) = curves.normal(law.mean_closure);
        println!("{:.4e} m, {:.4e} Pa", law.mean_closure, pressure);
        assert!((pressure / law.mean_pressure - 1.0).abs() < 1e-6);
        assert!(
            found
                .amplitudes()
                .iter()
                .all(|amplitude| amplitude.point.result.is_ok())
        );
    }
}

fn by_strength(limit: &str) -> Value {
    json!({ "interfaces": {
        "surface": "measured", "mu": null, "points_per_direction": 1,
        "law": {
            "friction": "resolved", "limit": limit, "bins": { "gauss": 8 },
            "yield": { "strength": "331.7 MPa", "tangent_modulus": "620 MPa" },
        },
    } })
}

/// Friction without a coefficient: more than that of a weak one, less than that of none.
#[test]
fn friction_follows_from_the_strength() {
    let scene = scene(&by_strength("shear-strength")).unwrap();
    assert_eq!(scene.interfaces.mu, 0.0);
    let run = go(&scene).unwrap();
    for amplitude in run.amplitudes() {
        let found = amplitude.point.result.as_ref().unwrap();
        println!("{:.3} rad/s, {:.3e}", found.omega, found.zeta);
        assert!(found.zeta >= -found.zeta_floor);
    }
}

#[test]
fn limits_by_strength_say_what_they_need() {
    let refused = |fields: Value| scene(&fields).unwrap_err().to_string();
    let mut with_mu = by_strength("ceb");
    with_mu["interfaces"]["mu"] = json!(0.2);
    let found = refused(with_mu);
    assert!(
        found.contains("interfaces.mu belongs to interfaces.law.limit"),
        "{found}"
    );
    let mut elastic = by_strength("ceb");
    elastic["interfaces"]["law"].as_object_mut().unwrap().remove("yield");
    let found = refused(elastic);
    assert!(
        found.contains("interfaces.law.limit belongs to interfaces.law.yield"),
        "{found}"
    );
    let mut methods = by_strength("shear-strength");
    methods["analyses"]["backbone"]["methods"] = json!(["qsma"]);
    let found = go(&scene(&methods).unwrap()).unwrap_err().to_string();
    assert!(found.contains("linearised"), "{found}");
}
