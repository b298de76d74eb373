//! What a texel was made from, so that pictures of it can be judged against the content itself.

use std::sync::Arc;

use crate::{BuildError, Geometry, Kind, Procedure};

/// What a texel was made from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Source {
    /// Nobody knows any more: such a texel can be looked at, but not judged.
    #[default]
    Unknown,
    /// These triangles.
    Geometry(Arc<Geometry>),
    /// Content grown by a procedure: its parameters are kept, and the triangles grown again when they are asked for.
    Grown(Kind),
}

impl Source {
    /// The triangles, the same bits every time; `None` where they are unknown.
    pub fn geometry(&self) -> Option<Arc<Geometry>> {
        match self {
            Self::Unknown => None,
            Self::Geometry(geometry) => Some(geometry.clone()),
            Self::Grown(kind) => Some(Arc::new(kind.geometry())),
        }
    }

    /// The triangles, checked: of a grown kind its parameters before anything grows.
    ///
    /// # Errors
    /// [`BuildError::Sourceless`] where they are unknown; else the first number out of its domain.
    pub(crate) fn sound_geometry(&self) -> Result<Arc<Geometry>, BuildError> {
        if let Self::Grown(kind) = self {
            kind.validate()?;
        }
        let geometry = self.geometry().ok_or(BuildError::Sourceless)?;
        geometry.validate()?;
        Ok(geometry)
    }
}

impl From<Geometry> for Source {
    fn from(geometry: Geometry) -> Self {
        Self::Geometry(Arc::new(geometry))
    }
}

impl From<Arc<Geometry>> for Source {
    fn from(geometry: Arc<Geometry>) -> Self {
        Self::Geometry(geometry)
    }
}

impl<K: Into<Kind>> From<K> for Source {
    fn from(kind: K) -> Self {
        Self::Grown(kind.into())
    }
}
