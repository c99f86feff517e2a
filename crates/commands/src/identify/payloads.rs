//! Known payloads, matched to their recordings.

use std::path::Path;

use armident_ident::KnownLoad;
use armident_model::ArmModel;
use armident_recording::Recording;

use super::PayloadOn;
use crate::failure::Failure;

pub(super) fn loads(
    payloads: &[PayloadOn],
    model: &ArmModel,
    read: [&[Recording]; 2],
) -> Result<Vec<KnownLoad>, Failure> {
    let mut loads: Vec<KnownLoad> = Vec::new();
    for given in payloads {
        let place = format!("--payload file={}", given.file.display());
        let all = || read.into_iter().flatten();
        let path = |recording: &Recording| Path::new(&recording.source).to_owned();
        let exact = all().find(|recording| path(recording) == given.file);
        let by_name =
            all().find(|recording| path(recording).file_name() == Some(given.file.as_os_str()));
        let Some(recording) = exact.or(by_name) else {
            let known: Vec<&str> = all().map(|recording| recording.source.as_str()).collect();
            return Err(Failure::new(
                "the payload's recording is not among the inputs",
                place,
                Some(format!("use one of {}", known.join(", "))),
            ));
        };
        let fault = if given.mass_kg <= 0.0 {
            Some((
                format!("the payload mass must be positive, found {} kg", given.mass_kg),
                "pass the weighed mass as mass=KG; omit --payload for a recording without a payload",
            ))
        } else if given.com_error_m < 0.0 {
            Some((
                format!("com_error must not be negative, found {} m", given.com_error_m),
                "pass the standard deviation of each coordinate of com [m]",
            ))
        } else if given.com_error_m > 0.0 && given.com_m.is_none() {
            Some((
                "com_error requires com".to_owned(),
                "pass com=X:Y:Z too, or omit both to estimate the centre of mass",
            ))
        } else if loads.iter().any(|load| load.is_on(&recording.source)) {
            Some((
                "the recording already has a payload".to_owned(),
                "pass one --payload per recording, with the total mass and its centre",
            ))
        } else {
            None
        };
        if let Some((what, hint)) = fault {
            return Err(Failure::new(what, place, Some(hint)));
        }
        loads.push(KnownLoad::new(
            &model.chain,
            &recording.source,
            given.mass_kg,
            given.com_m,
            given.com_error_m,
        ));
    }
    Ok(loads)
}
