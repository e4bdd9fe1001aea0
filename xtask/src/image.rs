//! What is in a firmware image: sizes, and symbols that must not be there.

use std::fmt;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use elf::ElfBytes;
use elf::abi::{SHF_ALLOC, SHF_EXECINSTR, SHT_NOBITS, SHT_REL, SHT_RELA, STT_FUNC};
use elf::endian::AnyEndian;
use rustc_demangle::demangle;

/// What an image may not contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forbidden {
    /// The machinery of panics: an input could stop the head.
    Panic,
    /// The heap.
    Heap,
    /// Arithmetic of 64-bit floats, which the processor's unit does not have: a call of 50 to 100 instructions each.
    F64,
}

impl Forbidden {
    /// All of it.
    pub const ALL: [Self; 3] = [Self::Panic, Self::Heap, Self::F64];

    /// Whether a function or variable of this name belongs to it.
    fn has(self, symbol: &str) -> bool {
        let readable = format!("{:#}", demangle(symbol));
        match self {
            Self::Panic => {
                readable.contains("core::panicking::")
                    || readable.contains("rust_begin_unwind")
                    || ["unwrap_failed", "expect_failed", "slice_index_fail"]
                        .iter()
                        .any(|f| readable.ends_with(f))
            }
            Self::Heap => {
                ["alloc::", "<alloc::"].iter().any(|start| readable.starts_with(start))
                    || ["__rust_alloc", "__rust_realloc", "__rg_alloc", "__rdl_alloc", "malloc"]
                        .iter()
                        .any(|name| readable.ends_with(name))
            }
            Self::F64 => {
                symbol.starts_with("__aeabi_d")
                    || (symbol.starts_with("__aeabi_") && symbol.ends_with("2d"))
                    || (symbol.starts_with("__") && symbol.contains("df"))
            }
        }
    }
}

impl fmt::Display for Forbidden {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Panic => "panic",
            Self::Heap => "heap",
            Self::F64 => "f64",
        })
    }
}

/// A function or variable of the firmware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    name: String,
    /// Address.
    pub start: u64,
    is_function: bool,
    /// Name of the section that it is in.
    pub section: String,
    /// Size, bytes.
    pub size: u64,
}

impl Symbol {
    /// The name as it is in the source, with its modules.
    pub fn readable(&self) -> String {
        format!("{:#}", demangle(&self.name))
    }
}

struct Section {
    name: String,
    start: u64,
    size: u64,
    loaded: bool,
    in_ram: bool,
}

/// A place in the code that refers to a symbol.
struct Reference {
    place: u64,
    symbol: usize,
}

/// A firmware image.
#[derive(Default)]
pub struct Image {
    sections: Vec<Section>,
    /// Address and bytes of what is loaded.
    contents: Vec<(u64, Vec<u8>)>,
    symbols: Vec<Symbol>,
    references: Vec<Reference>,
}

impl Image {
    /// Reads an ELF file that was linked with `--emit-relocs`.
    ///
    /// # Errors
    /// The file cannot be read, is no ELF file, or was stripped of its symbols.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&bytes).with_context(|| format!("{} is no firmware image", path.display()))
    }

    fn parse(bytes: &[u8]) -> Result<Self> {
        let file = ElfBytes::<AnyEndian>::minimal_parse(bytes)?;
        let (headers, names) = file.section_headers_with_strtab()?;
        let (headers, names) = (headers.context("no sections")?, names.context("no names of sections")?);
        let mut sections = Vec::new();
        let mut references = Vec::new();
        let mut contents = Vec::new();
        for header in headers.iter() {
            let name = names.get(header.sh_name as usize)?.to_owned();
            let occupies = header.sh_flags & u64::from(SHF_ALLOC) != 0;
            let loaded = occupies && header.sh_type != SHT_NOBITS;
            let in_ram = occupies && [".data", ".bss", ".uninit"].contains(&name.as_str());
            if loaded {
                contents.push((header.sh_addr, file.section_data(&header)?.0.to_vec()));
            }
            sections.push(Section { name, start: header.sh_addr, size: header.sh_size, loaded, in_ram });
            let is_of_code = matches!(header.sh_type, SHT_REL | SHT_RELA)
                && headers.get(header.sh_info as usize)?.sh_flags & u64::from(SHF_EXECINSTR) != 0;
            if is_of_code && header.sh_type == SHT_REL {
                let found = file.section_data_as_rels(&header)?;
                references.extend(found.map(|r| Reference { place: r.r_offset, symbol: r.r_sym as usize }));
            } else if is_of_code {
                let found = file.section_data_as_relas(&header)?;
                references.extend(found.map(|r| Reference { place: r.r_offset, symbol: r.r_sym as usize }));
            }
        }
        let (table, names) = file.symbol_table()?.context("no symbols")?;
        let mut symbols = Vec::new();
        for symbol in table.iter() {
            symbols.push(Symbol {
                name: names.get(symbol.st_name as usize)?.to_owned(),
                // The lowest bit of a function's address says that it is Thumb code.
                start: symbol.st_value & !1,
                is_function: symbol.st_symtype() == STT_FUNC,
                section: sections
                    .get(symbol.st_shndx as usize)
                    .map_or("", |section| &section.name)
                    .to_owned(),
                size: symbol.st_size,
            });
        }
        Ok(Self { sections, contents, symbols, references })
    }

    /// Bytes of flash: code, constants, and what variables start with.
    pub fn flash(&self) -> u64 {
        self.sections.iter().filter(|section| section.loaded).map(|section| section.size).sum()
    }

    /// Bytes of RAM: the variables, without the stack.
    pub fn ram(&self) -> u64 {
        self.sections.iter().filter(|section| section.in_ram).map(|section| section.size).sum()
    }

    /// Bytes of RAM above the variables, for the stack; `None` where the image does not say where it starts.
    pub fn room_for_stack(&self) -> Option<u64> {
        let ends = self.sections.iter().filter(|section| section.in_ram).map(|s| s.start + s.size);
        self.variable("_stack_start")?.start.checked_sub(ends.max()?)
    }

    /// Functions and variables of a forbidden kind, each with the functions that need it.
    pub fn find(&self, kind: Forbidden) -> Vec<String> {
        let forbidden = |symbol: &&Symbol| kind.has(&symbol.name);
        let mut found: Vec<String> = self.symbols.iter().filter(forbidden).map(Symbol::readable).collect();
        for reference in &self.references {
            let Some(callee) = self.symbols.get(reference.symbol).filter(forbidden) else { continue };
            if let Some(caller) = self.function_at(reference.place).filter(|caller| !forbidden(caller)) {
                let (caller, callee) = (caller.readable(), callee.readable());
                found.push(format!("{caller} needs {callee} at {:#x}", reference.place));
            }
        }
        found
    }

    /// The function at this address.
    pub fn function_at(&self, place: u64) -> Option<&Symbol> {
        self.symbols.iter().find(|s| s.is_function && (s.start..s.start + s.size.max(1)).contains(&place))
    }

    /// Every function.
    pub fn functions(&self) -> impl Iterator<Item = &Symbol> {
        self.symbols.iter().filter(|symbol| symbol.is_function)
    }

    /// The function of this name, whatever module it is in.
    pub fn function(&self, name: &str) -> Option<&Symbol> {
        self.symbols.iter().find(|s| s.is_function && s.readable().rsplit("::").next() == Some(name))
    }

    /// The word at an address.
    pub fn word(&self, place: u64) -> Option<u32> {
        self.contents.iter().find_map(|(start, bytes)| {
            let offset = usize::try_from(place.checked_sub(*start)?).ok()?;
            Some(u32::from_le_bytes(*bytes.get(offset..)?.first_chunk()?))
        })
    }

    /// The variable of this name, whatever module it is in.
    pub fn variable(&self, name: &str) -> Option<&Symbol> {
        self.symbols.iter().find(|symbol| symbol.readable().rsplit("::").next() == Some(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(symbol: &str) -> Vec<Forbidden> {
        Forbidden::ALL.into_iter().filter(|kind| kind.has(symbol)).collect()
    }

    #[test]
    fn stack_lies_above_the_variables() {
        let section = |name: &str, start, size, in_ram: bool| Section {
            name: name.to_owned(),
            start,
            size,
            loaded: !in_ram,
            in_ram,
        };
        let top = |start| Symbol {
            name: "_stack_start".to_owned(),
            start,
            is_function: false,
            section: String::new(),
            size: 0,
        };
        let image = |start| Image {
            sections: vec![
                section(".text", 0x4000_0000, 0x500, false),
                section(".data", 0x2000_0000, 0x10, true),
                section(".bss", 0x2000_0010, 0x90, true),
            ],
            symbols: vec![top(start)],
            ..Image::default()
        };
        assert_eq!(image(0x2000_0100).room_for_stack(), Some(0x60));
        assert_eq!(image(0x2000_0080).room_for_stack(), None);
        assert_eq!(Image::default().room_for_stack(), None);
    }

    #[test]
    fn forbidden_symbols_are_told_from_the_others() {
        for symbol in [
            "_ZN4core9panicking18panic_bounds_check17h0123456789abcdefE",
            "_ZN4core9panicking9panic_fmt17h0123456789abcdefE",
            "_RNvCsdBezzDwma51_7___rustc17rust_begin_unwind",
            "_ZN4core6option13unwrap_failed17h0123456789abcdefE",
        ] {
            assert_eq!(kinds(symbol), [Forbidden::Panic], "{symbol}");
        }
        for symbol in ["__rust_alloc", "malloc", "_ZN5alloc5alloc8box_free17h0123456789abcdefE"] {
            assert_eq!(kinds(symbol), [Forbidden::Heap], "{symbol}");
        }
        for symbol in
            ["__aeabi_dadd", "__aeabi_f2d", "__aeabi_ui2d", "__aeabi_dcmplt", "__muldf3", "__truncdfsf2"]
        {
            assert_eq!(kinds(symbol), [Forbidden::F64], "{symbol}");
        }
        for symbol in [
            "__aeabi_ldivmod",
            "__aeabi_fadd",
            "memcpy",
            "_ZN10concentric3fit5solve17h0123456789abcdefE",
            "main",
        ] {
            assert_eq!(kinds(symbol), [], "{symbol}");
        }
    }
}
