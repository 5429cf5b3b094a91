//! Reads CDR ([`crate::output::log::encoding::cdr`]) with every length checked: a damaged message is an error, never a panic or a huge allocation.

/// Reads one message.
pub(crate) struct CdrReader<'d> {
    data: &'d [u8],
    at: usize,
}

impl<'d> CdrReader<'d> {
    /// After the encapsulation.
    pub(crate) fn new(data: &'d [u8]) -> Result<Self, String> {
        match data.split_at_checked(4) {
            Some(([0, 1, _, _], data)) => Ok(CdrReader { data, at: 0 }),
            _ => Err("it is not little-endian CDR".to_string()),
        }
    }

    fn bytes(&mut self, count: usize) -> Result<&'d [u8], String> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.data.len());
        let end = end.ok_or_else(|| format!("it ends after {} bytes", self.data.len()))?;
        let bytes = &self.data[self.at..end];
        self.at = end;
        Ok(bytes)
    }

    /// The bytes of a number.
    pub(crate) fn aligned<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        self.bytes(N)?.try_into().map_err(|_| "it ends too early".to_string())
    }

    /// A length, count or other unsigned number of four bytes.
    pub(crate) fn unsigned(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.aligned()?))
    }

    /// A string.
    pub(crate) fn string(&mut self) -> Result<String, String> {
        let length = self.unsigned()? as usize;
        let bytes = self.bytes(length)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).map_err(|_| "a name is not UTF-8".to_string())
    }

    /// `N` doubles that are fields one after the other.
    pub(crate) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.aligned()?);
        }
        Ok(numbers)
    }

    /// `N` numbers of four bytes with a fraction.
    pub(crate) fn singles<const N: usize>(&mut self) -> Result<[f32; N], String> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f32::from_le_bytes(self.aligned()?);
        }
        Ok(numbers)
    }

    /// A sequence.
    pub(crate) fn sequence<T>(
        &mut self,
        mut element: impl FnMut(&mut Self) -> Result<T, String>,
    ) -> Result<Vec<T>, String> {
        let count = self.unsigned()?;
        // Grown as elements come, because a damaged count may be anything.
        let mut all = Vec::new();
        for _ in 0..count {
            all.push(element(self)?);
        }
        Ok(all)
    }

    /// A sequence of strings.
    pub(crate) fn strings(&mut self) -> Result<Vec<String>, String> {
        self.sequence(Self::string)
    }

    /// A sequence of doubles.
    pub(crate) fn doubles(&mut self) -> Result<Vec<f64>, String> {
        self.sequence(|cdr| Ok(f64::from_le_bytes(cdr.aligned()?)))
    }

    /// A `builtin_interfaces/Time`.
    pub(crate) fn time(&mut self) -> Result<(), String> {
        self.unsigned()?;
        self.unsigned().map(drop)
    }

    /// A `std_msgs/Header`.
    pub(crate) fn header(&mut self) -> Result<(), String> {
        self.frame().map(drop)
    }

    /// The frame of a `std_msgs/Header`.
    pub(crate) fn frame(&mut self) -> Result<String, String> {
        self.time()?;
        self.string()
    }
}
