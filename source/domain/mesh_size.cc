// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/mesh_size.h>
#include <dovetail/scene/undefined.h>

#include <deal.II/base/types.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <unistd.h>

namespace dovetail {

namespace {

/// Of this computer, or of the container in it, in bytes.
double memory_here()
{
  double memory = double(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
  double limit = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit && limit > 0)
    memory = std::min(memory, limit);
  return memory;
}

/// Of all computers on which ranks run; each counts once.
double memory_of_all(const MPI_Comm &communicator)
{
  MPI_Comm this_computer;
  MPI_Comm_split_type(communicator, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &this_computer);
  const bool is_first = dealii::Utilities::MPI::this_mpi_process(this_computer) == 0;
  MPI_Comm_free(&this_computer);
  return dealii::Utilities::MPI::sum(is_first ? memory_here() : 0., communicator);
}

/// At least what an unknown takes: value and column of each unknown that shares a cell, or where products
/// take the place of entries what vectors, points and the preconditioner do.
template <int dim>
double bytes_of_row(const unsigned int degree, const unsigned int n_components)
{
  const double of_entries = 12. * n_components * std::pow(std::max(3u, degree + 1), dim), of_products = 400;
  return degree == 1 ? of_entries : std::min(of_entries, of_products);
}

bool can_be_numbered(const double n_unknowns)
{
  return n_unknowns <= double(std::numeric_limits<int>::max()) ||
         sizeof(dealii::types::global_dof_index) > sizeof(int);
}

void check_memory(const Section &section, const std::string &entry, const std::string &what,
                  const double bytes, const MPI_Comm &communicator)
{
  const double memory = memory_of_all(communicator);
  constexpr double GiB = 1024. * 1024 * 1024;
  section.check(bytes <= memory, entry,
                "would give about " + what + ", which need at least " + in_words(bytes / GiB, 3) +
                    " GiB of memory, more than there is. Make the mesh coarser, or use more computers.");
}

} // namespace

template <int dim>
void check_cells(const Section &section, const std::string &entry, const double n_cells,
                 const double n_copies, const MPI_Comm &communicator)
{
  // measured with deal.II 9.4: 420 with the numbering (2D), 660 (3D, hexahedra), 570 a copy (tetrahedra)
  constexpr double bytes_of_cell = dim == 2 ? 400 : 550;
  check_memory(section, entry, in_words(n_cells, 3) + " cells",
               n_cells * (bytes_of_cell * n_copies + bytes_of_row<dim>(1, 1)), communicator);
}

template <int dim>
void check_unknowns(const Section &section, const double n_cells, const unsigned int degree,
                    const unsigned int n_components, const MPI_Comm &communicator)
{
  const double n_unknowns = n_cells * std::pow(degree, dim) * n_components;
  section.check(can_be_numbered(n_unknowns), "Degree",
                "would give about " + in_words(n_unknowns, 3) +
                    " unknowns, more than this deal.II can number. Make the mesh coarser, or use a deal.II "
                    "with 64-bit indices.");
  check_memory(section, "Degree", in_words(n_unknowns, 3) + " unknowns",
               n_unknowns * bytes_of_row<dim>(degree, n_components), communicator);
}

void check_total(const double n_unknowns)
{
  if (!can_be_numbered(n_unknowns))
    throw UserError("The Domains together have " + in_words(n_unknowns, 3) +
                    " unknowns, more than this deal.II can number. Make the meshes coarser, or use a deal.II "
                    "with 64-bit indices.");
}

template void check_cells<2>(const Section &, const std::string &, double, double, const MPI_Comm &);
template void check_cells<3>(const Section &, const std::string &, double, double, const MPI_Comm &);
template void check_unknowns<2>(const Section &, double, unsigned int, unsigned int, const MPI_Comm &);
template void check_unknowns<3>(const Section &, double, unsigned int, unsigned int, const MPI_Comm &);

} // namespace dovetail
