//! Where the items of a scene come from.

use crate::accel::ALLOCATION;

/// The objects of the JSON that items come from.
#[derive(Debug, Default)]
pub struct Sources {
    pub(super) lists: Vec<String>,
    /// Which of them are in the file of a model, and have the pointer of that. Empty: none.
    pub(super) models: Vec<bool>,
    pub(super) entries: Vec<Source>,
    /// JSON pointers of the materials.
    pub(super) materials: Vec<String>,
}

#[derive(Debug)]
pub(super) struct Source {
    pub(super) list: u32,
    pub(super) index: u32,
    pub(super) name: Option<Box<str>>,
}

impl Sources {
    pub(super) fn bytes(&self) -> usize {
        let texts = self.lists.iter().chain(&self.materials);
        let lists: usize = texts.map(|list| ALLOCATION + size_of::<String>() + list.len()).sum();
        let names = self.entries.iter().filter_map(|entry| entry.name.as_deref());
        let names: usize = names.map(|name| ALLOCATION + name.len()).sum();
        lists + size_of_val(&self.entries[..]) + names
    }

    /// JSON pointer of an item's object.
    pub fn pointer(&self, source: u32) -> String {
        let entry = &self.entries[source as usize];
        if self.models.get(entry.list as usize) == Some(&true) {
            return self.lists[entry.list as usize].clone();
        }
        format!("{}/{}", self.lists[entry.list as usize], entry.index)
    }

    /// Index in `objects` of what an item of the scene itself is, or is in: 3 of `/objects/3/group/objects/0`.
    pub fn top(&self, source: u32) -> u32 {
        let entry = &self.entries[source as usize];
        let inside = self.lists[entry.list as usize].strip_prefix("/objects/");
        let index = inside.and_then(|rest| rest.split('/').next()?.parse().ok());
        index.unwrap_or(entry.index)
    }

    /// How many `objects` the scene has.
    pub fn objects(&self) -> u32 {
        // The scene's own list is the first.
        self.entries.iter().filter(|entry| entry.list == 0).count() as u32
    }

    /// JSON pointer of a material; `default` for that of bodies which name none.
    pub fn material(&self, material: u32) -> &str {
        self.materials.get(material as usize).map_or("default", String::as_str)
    }

    /// Name of an item's object.
    pub fn name(&self, source: u32) -> Option<&str> {
        self.entries[source as usize].name.as_deref()
    }
}
