// From a file on the command line to what it holds; what is wrong with it is told on stderr.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "convert/console.h"
#include "core/compound/compound_surface.h"
#include "core/part_program/part_program.h"

namespace diesink {

// Either the value, or the exit status of what went wrong, which has been told.
template <class T>
struct Loaded {
  std::optional<T> value;
  ExitStatus status = ExitStatus::kDone;
};

// True where the content can only be meant as a part program: its first statement begins a section
// or is UNITS; an ending `.part` decides where the content does not, and is no binary mesh.
bool is_part_program(std::span<const std::byte> bytes, const std::string& path);

// Reads and checks a part program ("-" is stdin). Its warnings are told, and kept in `diagnostics`.
Loaded<PartProgram> load_part_program(const std::string& path, Diagnostics& diagnostics);
// The same for the content of `path`, read before.
Loaded<PartProgram> load_part_program(std::span<const std::byte> bytes, const std::string& path,
                                      Diagnostics& diagnostics);

// The compound surface of a checked program, everything there is to say kept in `diagnostics`,
// which holds no error yet, and nothing told; empty where there was an error.
std::optional<CompoundSurface> surface_of(const PartProgram& program, Diagnostics& diagnostics);

// The same, told on stderr, only the warnings kept. The scan of a MESH base is read from beside it.
// A scan's lengths are taken in its file's unit, or where that is not said in the program's; its Y
// axis is up only where the file says so.
Loaded<CompoundSurface> make_surface(const PartProgram& program,
                                     Diagnostics* diagnostics = nullptr);

// Both in one.
Loaded<CompoundSurface> load_surface(const std::string& path);

}  // namespace diesink
