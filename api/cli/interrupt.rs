//! Ctrl-C: the first one cancels the render, the second ends the process at once.

use super::failure::Failure;
use std::thread;
use strahl::render::Control;

/// From now on Ctrl-C cancels this render.
pub(super) fn cancel_on_ctrl_c(control: &Control) -> Result<(), Failure> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|error| Failure::Input(format!("Ctrl-C cannot be watched for: {error}")))?;
    let control = control.clone();
    thread::spawn(move || {
        runtime.block_on(async {
            if tokio::signal::ctrl_c().await.is_ok() {
                control.cancel();
            }
            if tokio::signal::ctrl_c().await.is_ok() {
                std::process::exit(130);
            }
        });
    });
    Ok(())
}
