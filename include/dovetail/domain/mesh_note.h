// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What was remarkable about a mesh when it was made.

#pragma once

#include <dovetail/domain/mesh.h>

#include <string>

namespace dovetail {

/// A base of meshes that remember it.
class WithNote
{
public:
  virtual ~WithNote() = default;
  std::string note; ///< a sentence for the user, or nothing
};

template <int dim>
std::string note_on_mesh(const Mesh<dim> &mesh)
{
  const auto *with_note = dynamic_cast<const WithNote *>(&mesh);
  return with_note == nullptr ? std::string() : with_note->note;
}

} // namespace dovetail
