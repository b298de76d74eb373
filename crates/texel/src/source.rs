//! What a texel was made from, so that pictures of it can be judged against the content itself.

use std::sync::Arc;

use crate::{BuildError, Density, Geometry, Kind, Procedure};

/// What a texel was made from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Source {
    /// Nobody knows any more: such a texel can be looked at, but not judged.
    #[default]
    Unknown,
    /// These triangles.
    Geometry(Arc<Geometry>),
    /// Content grown by a procedure: its parameters are kept, and the triangles, or the density, made again when they are
    /// asked for.
    Grown(Kind),
}

impl Source {
    /// The triangles, the same bits every time; `None` where they are unknown, or where the content is a density.
    pub fn geometry(&self) -> Option<Arc<Geometry>> {
        match self {
            Self::Unknown => None,
            Self::Geometry(geometry) => Some(geometry.clone()),
            Self::Grown(kind) => kind.density().is_none().then(|| Arc::new(kind.geometry())),
        }
    }

    /// The density, where the content is one.
    pub fn density(&self) -> Option<Density> {
        match self {
            Self::Grown(kind) => kind.density(),
            Self::Unknown | Self::Geometry(_) => None,
        }
    }

    /// The content, checked: of a grown kind its parameters before anything grows.
    ///
    /// # Errors
    /// [`BuildError::Sourceless`] where it is unknown; else the first number out of its domain.
    pub(crate) fn sound_content(&self) -> Result<Content, BuildError> {
        if let Self::Grown(kind) = self {
            kind.validate()?;
        }
        if let Some(density) = self.density() {
            return Ok(Content::Density(density));
        }
        let geometry = self.geometry().ok_or(BuildError::Sourceless)?;
        geometry.validate()?;
        Ok(Content::Triangles(geometry))
    }

    /// Checks the numbers that are kept: triangles, or the parameters of a kind.
    ///
    /// # Errors
    /// The first that is out of its domain.
    pub fn validate(&self) -> Result<(), BuildError> {
        match self {
            Self::Unknown => Ok(()),
            Self::Geometry(geometry) => geometry.validate(),
            Self::Grown(kind) => kind.validate(),
        }
    }
}

/// What there is to measure.
pub(crate) enum Content {
    Triangles(Arc<Geometry>),
    Density(Density),
}

impl Content {
    /// Specular albedo, and roughness of the highlight.
    pub(crate) fn material(&self) -> [f32; 2] {
        match self {
            Self::Triangles(geometry) => [geometry.specular, geometry.roughness],
            Self::Density(density) => density.material(),
        }
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
