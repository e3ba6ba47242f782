// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// deal.II's mesh generators, called by name. Their preconditions are assertions of its Debug library only, so
// arguments are checked here first.

#pragma once

#include <dovetail/scene/section.h>

#include <deal.II/grid/tria.h>

namespace dovetail {

/// The mesh of `Generator` with `Arguments`.
template <int dim>
class MeshGenerator
{
public:
  /// @throw UserError if there is no such generator or if the arguments do not fit
  MeshGenerator(const Section &section, const std::string &name, const std::string &arguments);

  /// About how many cells it will make, as far as the arguments tell: the product of all counts.
  double n_cells() const { return cells; }
  void make(dealii::Triangulation<dim> &mesh) const;

private:
  std::vector<std::string> ask_for_signature() const;
  void check_arguments(const std::vector<std::string> &kinds);
  void check_argument(const std::string &kind, const std::string &argument);
  void check_steps(const std::vector<std::string> &words);
  void count(const std::string &word, unsigned int smallest);
  double to_number(const std::string &word) const;
  [[noreturn]] void fail(const std::string &message) const;
  void check(const bool condition, const std::string &message) const
  {
    if (!condition)
      fail(message);
  }

  const Section section;
  const std::string name, arguments;
  double cells = 1;
};

} // namespace dovetail
