// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
//   bind_symbols LIBRARY COPY
//
// Copies a shared library of x86-64 and binds in the copy what it looks up in itself for its tables of
// virtual functions and the like, as the linker's option -Bsymbolic would have done: addresses of functions
// and of data that nobody writes. The loader then adds one number where it would look up a name. Data that is
// written, and symbols that all libraries must share, are looked up as before.

#include <cstdint>
#include <cstring>
#include <elf.h>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

namespace {

std::vector<char> file;

template <typename T>
T *at(const std::uint64_t offset)
{
  return reinterpret_cast<T *>(file.data() + offset);
}

/// Of an address of the library in its file.
std::uint64_t offset_of(const std::uint64_t address)
{
  const auto *header = at<Elf64_Ehdr>(0);
  for (unsigned int i = 0; i < header->e_phnum; ++i) {
    const auto &segment = at<Elf64_Phdr>(header->e_phoff)[i];
    if (segment.p_type == PT_LOAD && address >= segment.p_vaddr &&
        address < segment.p_vaddr + segment.p_filesz)
      return address - segment.p_vaddr + segment.p_offset;
  }
  throw "an address is in no segment";
}

/// In a part that is not written after the start.
bool is_constant(const std::uint64_t address)
{
  const auto *header = at<Elf64_Ehdr>(0);
  bool constant = false;
  for (unsigned int i = 0; i < header->e_phnum; ++i) {
    const auto &segment = at<Elf64_Phdr>(header->e_phoff)[i];
    if (address >= segment.p_vaddr && address < segment.p_vaddr + segment.p_memsz)
      constant = constant || segment.p_type == PT_GNU_RELRO ||
                 (segment.p_type == PT_LOAD && (segment.p_flags & PF_W) == 0);
  }
  return constant;
}

bool can_be_bound(const Elf64_Sym &symbol)
{
  const auto type = ELF64_ST_TYPE(symbol.st_info), binding = ELF64_ST_BIND(symbol.st_info);
  return symbol.st_shndx != SHN_UNDEF && symbol.st_shndx < SHN_LORESERVE &&
         (binding == STB_GLOBAL || binding == STB_WEAK) &&
         (type == STT_FUNC || (type == STT_OBJECT && is_constant(symbol.st_value)));
}

void bind()
{
  const auto *header = at<Elf64_Ehdr>(0);
  if (file.size() < sizeof(Elf64_Ehdr) || std::memcmp(header->e_ident, ELFMAG, SELFMAG) != 0 ||
      header->e_ident[EI_CLASS] != ELFCLASS64 || header->e_machine != EM_X86_64)
    throw "not a library of x86-64";
  std::uint64_t symbols = 0, relocations = 0, size = 0;
  for (unsigned int i = 0; i < header->e_phnum; ++i)
    if (const auto &segment = at<Elf64_Phdr>(header->e_phoff)[i]; segment.p_type == PT_DYNAMIC)
      for (const auto *entry = at<Elf64_Dyn>(segment.p_offset); entry->d_tag != DT_NULL; ++entry) {
        if (entry->d_tag == DT_SYMTAB)
          symbols = entry->d_un.d_ptr;
        if (entry->d_tag == DT_RELA)
          relocations = entry->d_un.d_ptr;
        if (entry->d_tag == DT_RELASZ)
          size = entry->d_un.d_val;
      }
  const auto *symbol_table = at<Elf64_Sym>(offset_of(symbols));
  auto *table = at<Elf64_Rela>(offset_of(relocations));
  for (std::uint64_t i = 0; i < size / sizeof(Elf64_Rela); ++i) {
    Elf64_Rela &relocation = table[i];
    const auto type = ELF64_R_TYPE(relocation.r_info);
    const Elf64_Sym &symbol = symbol_table[ELF64_R_SYM(relocation.r_info)];
    if ((type != R_X86_64_64 && type != R_X86_64_GLOB_DAT) || !can_be_bound(symbol))
      continue;
    relocation.r_addend = symbol.st_value + (type == R_X86_64_64 ? relocation.r_addend : 0);
    relocation.r_info = ELF64_R_INFO(0, R_X86_64_RELATIVE);
  }
}

} // namespace

int main(int argc, char **argv)
{
  try {
    if (argc != 3)
      throw "bind_symbols LIBRARY COPY";
    std::ifstream in(argv[1], std::ios::binary);
    file.assign(std::istreambuf_iterator<char>(in), {});
    bind();
    std::ofstream out(argv[2], std::ios::binary);
    if (!out.write(file.data(), file.size()).flush())
      throw "the copy cannot be written";
    return 0;
  } catch (const char *problem) {
    std::cerr << problem << std::endl;
    return 1;
  }
}
