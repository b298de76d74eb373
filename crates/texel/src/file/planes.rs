//! Records of a fixed width, stored byte by byte: all their first bytes, then all their second, and so on. What is alike
//! then stands together, and packs to a third less.

/// Appends `records`.
pub(super) fn write<const N: usize>(out: &mut Vec<u8>, records: impl ExactSizeIterator<Item = [u8; N]>) {
    let (start, count) = (out.len(), records.len());
    out.resize(start + N * count, 0);
    for (i, record) in records.enumerate() {
        for (plane, byte) in record.into_iter().enumerate() {
            out[start + plane * count + i] = byte;
        }
    }
}

/// What is left to read of a part.
pub(super) struct Planes<'a>(pub &'a [u8]);

impl<'a> Planes<'a> {
    /// The next `count` records, if there are so many.
    pub fn read<const N: usize>(
        &mut self,
        count: usize,
    ) -> Option<impl ExactSizeIterator<Item = [u8; N]> + 'a> {
        let (planes, rest) = self.0.split_at_checked(count.checked_mul(N)?)?;
        self.0 = rest;
        Some((0..count).map(move |i| std::array::from_fn(|plane| planes[plane * count + i])))
    }

    /// The next `count` records, if there are so many, where they stand one after the other.
    pub fn read_rows<const N: usize>(
        &mut self,
        count: usize,
    ) -> Option<impl ExactSizeIterator<Item = [u8; N]> + 'a> {
        let (rows, rest) = self.0.split_at_checked(count.checked_mul(N)?)?;
        self.0 = rest;
        Some((0..count).map(move |i| std::array::from_fn(|byte| rows[N * i + byte])))
    }

    /// The next `N` counts.
    pub fn counts<const N: usize>(&mut self) -> Option<[usize; N]> {
        let mut counts = [0; N];
        counts.iter_mut().try_for_each(|count| self.u32().map(|n| *count = n as usize))?;
        Some(counts)
    }

    /// The next whole number.
    pub fn u32(&mut self) -> Option<u32> {
        self.read::<4>(1)?.next().map(u32::from_le_bytes)
    }
}
