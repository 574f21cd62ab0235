//! Common parts of commands about a scene: the rendering threads, the scene, and Ctrl-C.

use super::failure::Failure;
use super::interrupt;
use super::places::Places;
use super::scene_args::{SceneArgs, SettingsArgs};
use super::scene_file::SceneFile;
use crate::service::scenes::prepared::PreparedScene;
use crate::service::scheduler::pool::{Pool, Workers};
use crate::service::scheduler::task::{Class, Task};
use std::convert::Infallible;
use std::time::Instant;
use strahl::film::Region;
use strahl::render::Control;
use strahl::scene::compile::Original;
use strahl::scene::limits::SCENE_BYTES;
use strahl::scene::{Description, Loaded, NotLoaded, Overrides, Scene};
use strahl::sequence::{Frame, Sequence};

/// A running command.
#[derive(Debug)]
pub(super) struct Session {
    /// The threads that render.
    pub(super) workers: Workers,
    /// Stops the render, and counts its progress.
    pub(super) control: Control,
    /// The scene's file.
    pub(super) file: SceneFile,
    /// When work on the scene began.
    pub(super) started: Instant,
    overrides: Overrides,
}

impl Session {
    /// Starts the threads and reads the scene's file.
    pub(super) fn start(scene: &SceneArgs, settings: &SettingsArgs) -> Result<Self, Failure> {
        Self::with(scene, settings, Control::default())
    }

    /// The same, from a file or a blob of the store.
    pub(super) fn start_at(scene: &SceneArgs, settings: &SettingsArgs, places: &Places) -> Result<Self, Failure> {
        let read = || Ok(SceneFile::given(scene, scene.scene.clone(), places.read(&scene.scene, SCENE_BYTES.max)?));
        Self::of(read, settings, Control::default())
    }

    /// The same with a control that other sessions have, too.
    pub(super) fn with(scene: &SceneArgs, settings: &SettingsArgs, control: Control) -> Result<Self, Failure> {
        Self::of(|| SceneFile::read(scene), settings, control)
    }

    fn of(
        read: impl FnOnce() -> Result<SceneFile, Failure>,
        settings: &SettingsArgs,
        control: Control,
    ) -> Result<Self, Failure> {
        let pool = Pool::start(settings.threads, None)
            .map_err(|error| Failure::Input(format!("the rendering threads cannot be started: {error}")))?;
        let (workers, started) = (pool.join(Task::new(Class::Renders, "", 1), control.clone()), Instant::now());
        let file = read()?;
        Ok(Self { workers, control, file, started, overrides: settings.overrides() })
    }

    /// A sequence of the scene. If the camera goes around a model, it stands where all of the model stays in the picture.
    pub(super) fn go_around(&mut self, frames: Sequence) -> Sequence {
        if !(self.file.format.is_model() || self.file.hidden_model().is_some()) {
            return frames;
        }
        self.overrides.model.around = frames.turntable.map(|_| true);
        frames.of_model()
    }

    /// From now on the first Ctrl-C stops the render, the second ends the process.
    pub(super) fn cancel_on_ctrl_c(&self) -> Result<(), Failure> {
        interrupt::cancel_on_ctrl_c(&self.control)
    }

    /// Fails once the render was stopped.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if self.control.is_cancelled() { Err(Failure::Interrupted) } else { Ok(()) }
    }

    /// Checks and builds the scene.
    pub(super) fn load(&self) -> Result<Loaded, Failure> {
        self.workers.work(|| self.file.load(&self.overrides))?
    }

    /// The scene with another camera, from its eye and target.
    pub(super) fn load_seen_from(&self, view: [[f64; 3]; 2]) -> Result<Loaded, Failure> {
        let overrides = Overrides { seen_from: Some(view), ..self.overrides };
        self.workers.work(|| self.file.load(&overrides))?
    }

    /// The scene of a frame.
    pub(super) fn load_frame(&self, frame: Frame<'_>, original: Original<'_>) -> Result<Loaded, Failure> {
        let accept = |_: &Description| Ok::<_, Infallible>(());
        let load = || frame.load_if(original, &self.overrides, &self.file.inputs, &accept);
        let loaded = self.workers.work(load)?;
        loaded.map_err(|NotLoaded::Problems(problems)| Failure::Scene { name: self.file.name.clone(), problems })
    }

    /// The scene of a frame, with its plan.
    pub(super) fn prepare_frame(&self, frame: Frame<'_>) -> Result<PreparedScene, Failure> {
        let base = self.load()?;
        let loaded = self.load_frame(frame, Original { description: &base.description, scene: &base.scene })?;
        Ok(self.workers.work(|| PreparedScene::without_id(loaded))?)
    }

    /// Checks and builds the scene, and plans its picture. The scene's text is gone afterwards.
    pub(super) fn prepare(&mut self) -> Result<PreparedScene, Failure> {
        let loaded = self.load_last()?;
        Ok(self.workers.work(|| PreparedScene::without_id(loaded))?)
    }

    /// The same, with the scene's id.
    pub(super) fn prepare_with_id(&mut self) -> Result<PreparedScene, Failure> {
        let loaded = self.load_last()?;
        Ok(self.workers.work(|| PreparedScene::new(loaded, None))?)
    }

    fn load_last(&mut self) -> Result<Loaded, Failure> {
        let Self { workers, file, overrides, .. } = self;
        workers.work(|| file.load_last(overrides))?
    }
}

/// The region asked for, or the whole picture.
pub(super) fn region_of(scene: &Scene, region: Option<Region>) -> Result<Region, Failure> {
    let Scene { width, height, .. } = *scene;
    let region = region.unwrap_or_else(|| Region::whole(width, height));
    if region.fits(width, height) {
        Ok(region)
    } else {
        Err(Failure::Usage(format!(
            "--region {},{},{},{} does not lie inside the picture of {width} x {height} pixels",
            region.x, region.y, region.width, region.height
        )))
    }
}
