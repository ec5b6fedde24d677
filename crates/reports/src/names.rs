//! Names of the files of a run.

/// Name of the machine-readable account of a run.
pub const SUMMARY: &str = "summary.json";

/// Name of the table of hysteresis loops of interface elements along quasi-static loops.
pub const ELEMENT_LOOPS: &str = "element-loops.csv";

/// Name of the interface file of an amplitude, counted from 1; `mode` is none for the first mode followed.
pub fn amplitude_file(mode: Option<usize>, number: usize) -> String {
    format!("interface-{}amplitude-{number:02}.vtu", of_mode(mode))
}

/// Name of the file of the deformed bodies at an amplitude, counted from 1; `mode` is none for the first mode followed.
pub fn bodies_file(mode: Option<usize>, number: usize) -> String {
    format!("bodies-{}amplitude-{number:02}.vtu", of_mode(mode))
}

/// Name of the file of the deformed bodies in the static state.
pub const BODIES_PRESTRESS: &str = "bodies-prestress.vtu";

/// Name of the interface file of the static state.
pub(crate) const PRESTRESS: &str = "interface-prestress.vtu";

/// Name of the list of the interface files of a mode over the amplitude, the static state being at zero; `mode` is none for the first mode
/// followed.
pub fn series_file(mode: Option<usize>) -> String {
    of_mode(mode) + "fields.pvd"
}

/// Name of the table of a backbone; `mode` is none for the first mode followed.
pub fn table_file(mode: Option<usize>) -> String {
    of_mode(mode) + "backbone.csv"
}

/// Name of the picture of a backbone; `mode` is none for the first mode followed.
pub fn picture_file(mode: Option<usize>) -> String {
    of_mode(mode) + "backbone.svg"
}

/// What distinguishes the files of a mode from those of the first mode followed.
pub(crate) fn of_mode(mode: Option<usize>) -> String {
    mode.map_or_else(String::new, |mode| format!("mode-{mode}-"))
}

/// The mode in the name of a file, none for the first mode followed, and the name without it.
pub(crate) fn by_mode(name: &str) -> (Option<usize>, &str) {
    let found = name.strip_prefix("mode-").and_then(|rest| {
        let (mode, rest) = rest.split_once('-')?;
        Some((mode.parse().ok()?, rest))
    });
    found.map_or((None, name), |(mode, rest)| (Some(mode), rest))
}

/// Whether a name is that of the fields of an amplitude, of the bodies deformed, of loops of elements, or of the backbone of a further mode.
pub(crate) fn is_of_backbones(name: &str) -> bool {
    if [BODIES_PRESTRESS, ELEMENT_LOOPS].contains(&name) {
        return true;
    }
    if let (Some(mode), _) = by_mode(name) {
        return [table_file, picture_file, series_file]
            .iter()
            .any(|of| of(Some(mode)) == name);
    }
    let of_amplitude = ["interface-", "bodies-"].map(|prefix| name.strip_prefix(prefix));
    let Some((mode, rest)) = of_amplitude.into_iter().flatten().next().map(by_mode) else {
        return false;
    };
    let number = rest
        .strip_prefix("amplitude-")
        .and_then(|rest| rest.strip_suffix(".vtu"));
    number.and_then(|number| number.parse().ok()).is_some_and(|amplitude| {
        [amplitude_file, bodies_file]
            .iter()
            .any(|of| of(mode, amplitude) == name)
    })
}
