// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// What stands behind a SceneText and all its Sections.

#pragma once

#include "declarations.h"
#include "scene_tree.h"

#include <dovetail/scene/scene_text.h>

namespace dovetail {

struct SceneState
{
  SceneTree tree;
  Declarations declarations;
  bool is_documenting = false;
  FileTexts tables;                                    ///< that formulas name, by their paths
  std::vector<FormulaWithTables> formulas_with_tables; ///< that have been read
  std::map<std::string, BoundaryNames> boundary_names; ///< by the sections of the domains, "Domain left"

  /// "Interface seam, scene.prm line 41: ", of the entry @p name if the scene has it, else of the section.
  std::string where(const std::string &path, const std::string &name = "") const;

  /// Throw the error that nobody knows the subsection @p path.
  [[noreturn]] void refuse_subsection(const std::string &path) const;
  /// @throw UserError naming a subsection that nobody has read if it looks like one that is asked for and not
  /// there: all that is wrong besides may follow from it, for instance a field that a material lacks.
  void refuse_misspelt_subsection() const;
};

struct SceneText::Implementation : SceneState
{
};

} // namespace dovetail
