//! All settings on one plane: seconds against the distance from a run whose settings are all fine.

use super::ladder::{Errors, Ladder, Measured, errors};
use super::parameters::{MEASURED_GAP, physics};
use brake_reuss_beam::published::FIRST_FREQUENCY;
use scenes::Scene;
use serde_json::{Value, json};

/// A setting on the plane.
pub(crate) struct Placed {
    /// Parameter and setting.
    pub(crate) name: String,
    /// From nothing to the backbone.
    pub(crate) seconds: f64,
    pub(crate) errors: Errors,
}

/// Settings that model the same, and how far other physics is from a measurement.
pub(crate) struct Front {
    /// By rising seconds.
    pub(crate) settings: Vec<Placed>,
    /// Least and largest relative distance of the first frequency from the measured one, over the physics to choose from; none where nothing was measured.
    pub(crate) physics: Option<[f64; 2]>,
}

impl Front {
    /// The scene itself, which gave `own`, and all settings of the physics of the scene `truth`, which was `measured`.
    pub(crate) fn new(ladders: &[Ladder], own: &Measured, truth: &Scene, measured: &Measured) -> Self {
        let same = physics(truth);
        let itself = Placed {
            name: "scene as it is".into(),
            seconds: own.seconds(),
            errors: errors(own, measured),
        };
        let placed = |ladder: &Ladder| -> Vec<Placed> {
            let parameter = &ladder.parameter;
            let settings = parameter.settings.iter().zip(&ladder.outcomes);
            let alike = settings.filter(|(setting, _)| physics(&setting.scene) == same);
            let found = alike.filter_map(|(setting, outcome)| {
                let own = outcome.measured.as_ref().ok()?;
                Some(Placed {
                    name: format!("{}: {}", parameter.name, setting.name),
                    seconds: own.seconds(),
                    errors: errors(own, measured),
                })
            });
            // Each parameter has the scene's own setting among its own.
            let found = found.filter(|placed| placed.errors != itself.errors);
            found.collect()
        };
        let mut settings: Vec<Placed> = ladders.iter().flat_map(placed).collect();
        settings.push(itself);
        settings.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let beside = ladders.iter().find(|ladder| ladder.parameter.name == MEASURED_GAP);
        let distances = beside
            .into_iter()
            .flat_map(|ladder| &ladder.outcomes)
            .filter_map(|outcome| {
                let own = outcome.measured.as_ref().ok()?;
                Some((own.linear / FIRST_FREQUENCY.measured - 1.0).abs())
            });
        let physics = distances.fold(None, |range: Option<[f64; 2]>, distance| {
            let [least, most] = range.unwrap_or([distance; 2]);
            Some([least.min(distance), most.max(distance)])
        });
        Self { settings, physics }
    }

    /// The settings than which none is both faster and as near, by an error; settings without one are none of them. A tenth of the error is no
    /// difference.
    pub(crate) fn best(&self, error: impl Fn(&Errors) -> Option<f64>) -> Vec<&Placed> {
        let mut least = f64::INFINITY;
        let is_best = |placed: &&Placed| match error(&placed.errors) {
            Some(own) if own < 0.9 * least => {
                least = own;
                true
            }
            _ => false,
        };
        self.settings.iter().filter(is_best).collect()
    }

    /// For `trade.json`.
    pub(crate) fn json(&self) -> Value {
        let names = |best: Vec<&Placed>| -> Vec<String> { best.iter().map(|placed| placed.name.clone()).collect() };
        let settings = self.settings.iter().map(|placed| {
            json!({
                "name": placed.name,
                "seconds": placed.seconds,
                "frequency": placed.errors.frequency(),
                "damping_ln": placed.errors.damping(),
            })
        });
        json!({
            "settings": settings.collect::<Vec<_>>(),
            "best": {
                "frequency": names(self.best(|errors| Some(errors.frequency()))),
                "damping_ln": names(self.best(Errors::damping)),
            },
            "physics": self.physics,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenes::{Bins, Friction};

    fn placed(name: &str, seconds: f64, linear: f64, damping: Option<f64>) -> Placed {
        let errors = Errors {
            linear,
            shift: [None; 3],
            damping: [damping, None, None],
        };
        Placed {
            name: name.into(),
            seconds,
            errors,
        }
    }

    #[test]
    fn only_what_nothing_faster_is_nearer_than_is_on_the_front() {
        let front = Front {
            settings: vec![
                placed("a", 1.0, 0.1, None),
                placed("b", 2.0, 0.2, Some(0.3)),
                placed("c", 3.0, -0.05, Some(-0.1)),
            ],
            physics: None,
        };
        let names = |best: Vec<&Placed>| -> Vec<String> { best.iter().map(|placed| placed.name.clone()).collect() };
        assert_eq!(names(front.best(|errors| Some(errors.frequency()))), ["a", "c"]);
        assert_eq!(names(front.best(Errors::damping)), ["b", "c"]);
        assert_eq!(front.json()["best"]["damping_ln"], json!(["b", "c"]));
    }

    #[test]
    fn numbers_of_bins_and_points_are_no_physics() {
        let scene = crate::paper_scene("paper").unwrap();
        let mut finer = scene.clone();
        finer.interfaces.law.bins = Bins::Gauss(64);
        finer.interfaces.points_per_direction = 5;
        assert_eq!(physics(&finer), physics(&scene));
        finer.interfaces.law.friction = Some(Friction::MindlinIwan);
        assert_ne!(physics(&finer), physics(&scene));
    }
}
