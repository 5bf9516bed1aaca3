//! A dataset read in blocks of whole chunks, several of them unpacked at once.

use hdf5_reader::{Dataset, Datatype, H5Type, SliceInfo, SliceInfoElem};

use crate::formats::FileFloat;
use crate::formats::gather::{BlockRange, Gather, cut};
use crate::formats::numbers::{Number, Stored};

/// Bytes of a block, as stored, beyond which it takes no further chunks.
const BLOCK: usize = 4 << 20;

/// The three axes of a dataset that are read, and how.
pub struct Slabs<'a> {
    dataset: &'a Dataset,
    axes: [usize; 3],
    /// Elements of a block along each axis; blocks begin at multiples of them.
    block: [usize; 3],
    /// Bytes that a block takes while it is unpacked.
    bytes: u64,
    packing: Packing,
}

/// How numbers were packed into those that are stored, by the words of netCDF.
#[derive(Debug, Clone, Default)]
pub struct Packing {
    /// Scale and offset of a number; `None` if it is unscaled.
    pub scale: Option<(f64, f64)>,
    /// Numbers that stand for none.
    pub blank: Vec<f64>,
    /// The lowest and the highest stored number that is valid.
    pub valid: Option<(f64, f64)>,
    /// Offset of negative numbers that netCDF's `_Unsigned` declares to be unsigned.
    pub unsigned: Option<f64>,
}

/// A fill value this large may be stored in another precision than the numbers.
const HUGE: f64 = 1e30;

impl Packing {
    /// True if every number is as it is stored.
    pub fn is_plain(&self) -> bool {
        self.scale.is_none() && self.unsigned.is_none()
    }

    fn value<T: FileFloat>(&self, stored: T) -> T {
        let mut number = stored.number();
        if number < 0.0 {
            number += self.unsigned.unwrap_or(0.0);
        }
        let is_blank = |blank: &f64| number == *blank || (blank.abs() > HUGE && (number / blank - 1.0).abs() < 1e-6);
        if self.blank.iter().any(is_blank) || self.valid.is_some_and(|(low, high)| !(low..=high).contains(&number)) {
            return T::of(f64::NAN);
        }
        match self.scale {
            Some((scale, offset)) => T::of(number * scale + offset),
            None if self.unsigned.is_some() => T::of(number),
            None => stored,
        }
    }
}

impl<'a> Slabs<'a> {
    /// Blocks for an array whose axes are these ones of the dataset, the slowest first.
    pub fn new(dataset: &'a Dataset, stored: Stored, axes: [usize; 3], packing: Packing) -> Self {
        let shape = axes.map(|axis| dataset.shape()[axis] as usize);
        let chunk = dataset.chunks();
        let chunk = axes.map(|axis| chunk.as_ref().and_then(|c| c.get(axis)).map_or(1, |edge| (*edge as usize).max(1)));
        let mut block = chunk;
        for axis in [2, 1, 0] {
            let others: usize = (0..3).filter(|i| *i != axis).fold(stored.size(), |bytes, i| bytes.saturating_mul(block[i]));
            let chunks = (BLOCK / others.saturating_mul(chunk[axis]).max(1)).clamp(1, shape[axis].div_ceil(chunk[axis]).max(1));
            block[axis] = chunks * chunk[axis];
        }
        // As stored, in the order of the block, and as numbers.
        let bytes = block.iter().fold(2 * stored.size() as u64 + 8, |bytes, edge| bytes.saturating_mul(*edge as u64));
        Self { dataset, axes, block, bytes, packing }
    }

    /// Requirements of `gather`.
    pub fn gathered<T: FileFloat>(&self, mut gather: Gather<T>, limit: u64) -> Result<Gather<T>, String> {
        let blocks = cut(&gather.ranges, self.block);
        gather.blocks(blocks, (self.bytes, limit), |_| Ok(()), |block, ()| self.read(block))?;
        Ok(gather)
    }

    fn read<T: FileFloat>(&self, block: &BlockRange) -> Result<Vec<T>, String> {
        let role = |axis: usize| match self.axes.iter().position(|known| *known == axis) {
            Some(i) => SliceInfoElem::Slice { start: block[i].start as u64, end: block[i].end as u64, step: 1 },
            None => SliceInfoElem::Index(0),
        };
        let selections = (0..self.dataset.ndim()).map(role).collect();
        let read = self.dataset.read_slice::<Value<T>>(&SliceInfo { selections });
        Ok(read.map_err(|e| e.to_string())?.into_raw_vec_and_offset().0.into_iter().map(|v| self.packing.value(v.0)).collect())
    }
}

/// A number of any stored type.
#[derive(Clone)]
pub struct Value<T>(pub T);

impl<T: FileFloat> H5Type for Value<T> {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], kind: &Datatype) -> hdf5_reader::error::Result<Self> {
        let mut value = None;
        if let Some(stored) = stored(kind) {
            stored.decode(bytes, |v| value = Some(Self(v)));
        }
        value.ok_or_else(|| hdf5_reader::error::Error::InvalidData("a value is not a number".into()))
    }

    fn element_size(kind: &Datatype) -> usize {
        stored(kind).map_or(0, Stored::size)
    }

    fn decode_vec(bytes: &[u8], kind: &Datatype, count: usize) -> Option<hdf5_reader::error::Result<Vec<Self>>> {
        let stored = stored(kind)?;
        let bytes = bytes.get(..count.checked_mul(stored.size())?)?;
        let mut values = Vec::with_capacity(count);
        stored.decode(bytes, |v| values.push(Self(v)));
        Some(Ok(values))
    }
}

/// How numbers of a type are stored; none where they are no real numbers.
pub fn stored(kind: &Datatype) -> Option<Stored> {
    let (kind, order) = match kind {
        Datatype::FixedPoint { size, signed: true, byte_order } => (Number::Int(usize::from(*size)), byte_order),
        Datatype::FixedPoint { size, signed: false, byte_order } => (Number::Uint(usize::from(*size)), byte_order),
        Datatype::FloatingPoint { size, byte_order } => (Number::Float(usize::from(*size)), byte_order),
        _ => return None,
    };
    Stored::new(kind, *order == hdf5_reader::ByteOrder::BigEndian)
}
