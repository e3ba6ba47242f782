// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What is shown of a body or of an interface: deal.II's patches in one .vtu file.

#pragma once

#include <dovetail/output/shared_file.h>

#include <deal.II/base/data_out_base.h>

#include <sstream>

namespace dovetail {

/// With which all .vtu files begin.
constexpr const char *beginning_of_vtu = "<?xml version=\"1.0\"";

/// What one rank adds to a file.
struct PieceOfPicture
{
  std::string text;     ///< compressed
  bool is_empty = true; ///< no patches: the text says just this
};

/// A file of the pieces of all ranks, of which empty ones are left out. The @p flags tell of higher-order
/// cells if some are of degree 3 or more. Instead of write_vtu_in_parallel(), which ends the program where
/// MPI cannot make its shared file pointer (long names), and waits for ever when the disk is full.
/// Collective, and the same result on all ranks.
Obstacle write_vtu(const std::string &file, const PieceOfPicture &piece,
                   const dealii::DataOutBase::VtkFlags &flags, const MPI_Comm &communicator);

/// A piece of Lagrange cells of degree 2 as one of VTK's quadratic cells, whose nodes have the same order and
/// which more programs read.
std::string with_quadratic_cells(const std::string &piece, unsigned int dim, unsigned int n_cells);

/// A patch of several parts is a cell of higher order, except on a line: deal.II orders the nodes of planes
/// and solids only.
template <int dim, int spacedim = dim>
class Picture : public dealii::DataOutInterface<dim, spacedim>
{
public:
  PieceOfPicture piece(dealii::DataOutBase::VtkFlags flags) const
  {
    const auto &patches = this->get_patches();
    const unsigned int degree = dim < 2 || patches.empty() ? 1 : patches.front().n_subdivisions;
    flags.write_higher_order_cells = degree > 1;
    std::ostringstream out;
    dealii::DataOutBase::write_vtu_main(patches, this->get_dataset_names(), this->get_nonscalar_data_ranges(),
                                        flags, out);
    return {degree == 2 ? with_quadratic_cells(out.str(), dim, patches.size()) : out.str(), patches.empty()};
  }
};

} // namespace dovetail
