//! Frames → `vdb/`.

use super::{FlowError, Job, Observer, each_frame};
use crate::cache;
use crate::export::{grids, vdb};

pub(super) fn work(job: &Job, _: &mut Observer<'_>) -> Result<(), FlowError> {
    each_frame(job, |frame| {
        let path = job.folder.vdb(frame.index);
        let mut bytes = Vec::new();
        vdb::write(&mut bytes, &grids::from_frame(frame, &job.scene.export))
            .map_err(FlowError::io(&path))?;
        Ok(cache::write(&path, &bytes)?)
    })?;
    Ok(())
}
