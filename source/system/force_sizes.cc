// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/force_sizes.h>

#include <dovetail/domain/point_products.h>

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

ForceSizes::ForceSizes(const Numbering &numbering) : numbering(&numbering)
{
  begin();
  tangent_at_x = products_at_x = of_forces;
}

void ForceSizes::begin()
{
  const std::vector<double> none(numbering->blocks().size(), 0.);
  of_forces = on_free = of_tangents = of_products = none;
}

void ForceSizes::add(const Dofs &dofs, const std::vector<double> &forces, const std::vector<double> &unknowns,
                     const unsigned int longest_sum, const Constraints &constraints,
                     const dealii::FullMatrix<double> *local_tangent)
{
  thread_local std::vector<double> row_sums;
  row_sums.assign(dofs.size(), 0.);
  if (local_tangent != nullptr &&
      std::any_of(unknowns.begin(), unknowns.end(), [](const double x) { return x != 0; }))
    add_up_sizes(dofs.size(), &(*local_tangent)(0, 0), unknowns.data(), row_sums.data());
  unsigned int block = 0; // that of the unknown before, most often
  for (unsigned int i = 0; i < dofs.size(); ++i) {
    const double row_sum = row_sums[i];
    const auto add_to = [&](const unsigned int block, const double weight) {
      const double force = weight * weight * forces[i] * forces[i];
      of_forces[block] += force;
      on_free[block] += longest_sum * force;
      of_products[block] += weight * weight * row_sum * row_sum;
      of_tangents[block] += longest_sum * weight * weight * row_sum * row_sum;
    };
    const Block &before = numbering->blocks()[block];
    if (dofs[i] < before.begin || dofs[i] >= before.end)
      block = numbering->block_of(dofs[i]);
    if (!constraints.is_constrained(dofs[i]))
      add_to(block, 1.);
    else {
      of_forces[block] += forces[i] * forces[i];
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dofs[i]))
        add_to(numbering->block_of(other), weight);
    }
  }
}

void ForceSizes::add_products(const Dofs &dofs, const std::vector<double> &products,
                              const unsigned int longest_sum, const Constraints &constraints)
{
  for (unsigned int i = 0; i < dofs.size(); ++i) {
    const auto add_to = [&](const unsigned int block, const double weight) {
      of_products[block] += weight * weight * products[i] * products[i];
      of_tangents[block] += longest_sum * weight * weight * products[i] * products[i];
    };
    if (!constraints.is_constrained(dofs[i]))
      add_to(numbering->block_of(dofs[i]), 1.);
    else
      for (const auto &[other, weight] : *constraints.get_constraint_entries(dofs[i]))
        add_to(numbering->block_of(other), weight);
  }
}

void ForceSizes::finish(const std::function<bool(unsigned int)> &has_tangent, const MPI_Comm &communicator)
{
  for (auto *block_sums : {&of_forces, &on_free, &of_tangents, &of_products})
    dealii::Utilities::MPI::sum(*block_sums, communicator, *block_sums);
  for (unsigned int b = 0; b < of_forces.size(); ++b)
    if (has_tangent(b)) {
      tangent_at_x[b] = of_tangents[b];
      products_at_x[b] = of_products[b];
    }
}

void ForceSizes::set_forces(std::vector<double> squares, const unsigned int longest_sum,
                            const MPI_Comm &communicator)
{
  of_forces = std::move(squares);
  dealii::Utilities::MPI::sum(of_forces, communicator, of_forces);
  on_free = of_forces;
  for (double &square : on_free)
    square *= longest_sum;
}

void ForceSizes::set_tangent(const std::vector<double> &products, const unsigned int longest_sum)
{
  for (unsigned int b = 0; b < products.size(); ++b)
    tangent_at_x[b] = longest_sum * std::pow(products[b], 2);
}

std::vector<double> ForceSizes::forces() const
{
  std::vector<double> norms;
  for (unsigned int b = 0; b < of_forces.size(); ++b)
    norms.push_back(
        std::sqrt(of_forces[b] + (numbering->blocks()[b].is_of_pressure() ? products_at_x[b] : 0)));
  return norms;
}

std::vector<double> ForceSizes::rounding() const
{
  const double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;
  std::vector<double> norms;
  for (unsigned int b = 0; b < on_free.size(); ++b)
    norms.push_back(unit_roundoff * (std::sqrt(on_free[b]) + std::sqrt(tangent_at_x[b])));
  return norms;
}

} // namespace dovetail
