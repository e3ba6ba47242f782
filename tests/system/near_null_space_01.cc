// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What the tangent does not see: K times the near-null space of bodies that nothing holds (their clamps are
// switched off) vanishes to 1e-13 of K, body by body without ties, and for both bodies together over
// Nitsche's tie with a gap; body by body it does not, because of the tie. The modes are of order one.
//
// ranks: 1, 2, 3

#include "scene_model.h"

using namespace test;

template <int dim>
std::string scene(const bool is_tied)
{
  const auto domain = [](const std::string &mesh) {
    std::string conditions;
    for (const std::string field : {"displacement", "temperature"})
      conditions +=
          subsection("Boundary condition " + field, set("Type", "value") + set("Field", field) +
                                                        set("Boundary ids", "2") + set("Toggle", "later") +
                                                        set("Expression", field == "temperature" ? "0"
                                                                          : dim == 2             ? "0; 0"
                                                                                     : "0; 0; 0"));
    return set("Material", "steel") + set("Boundary conditions", "displacement, temperature") + conditions +
           mesh;
  };
  const std::string zero = dim == 2 ? "0" : "0, 0", one = dim == 2 ? "1" : "1, 1";
  return set("Materials", "steel") + set("Domains", "left, right") + set("Toggles", "later") +
         subsection("Toggle later", set("Active while", "t > 5")) +
         subsection("Material steel",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "2") +
                                            set("Poisson ratio", "0.3")) +
                        subsection("Heat", set("Type", "Fourier") + set("Conductivity", "2"))) +
         subsection("Domain left",
                    domain(box((dim == 2 ? "3, 4 : 10, " : "1, 2, 2 : 10, ") + zero + " : 11, " + one))) +
         subsection("Domain right", domain(box((dim == 2 ? "2, 3 : 11.01, " : "2, 1, 1 : 11.01, ") + zero +
                                               " : 12, " + one))) +
         (is_tied ? set("Interfaces", "seam") +
                        subsection("Interface seam", set("Type", "Nitsche") + set("Source", "left : 1") +
                                                         set("Destination", "right : 0"))
                  : "");
}

/// Of the block on the diagonal.
template <int dim>
double frobenius_norm(const BlockSystem<dim> &system, const Block &block)
{
  double square = 0;
  std::vector<BlockMatrix::size_type> columns;
  std::vector<double> values;
  for (const auto row : block.owned) {
    system.tangent().extract_row(block.begin + row, columns, values);
    for (unsigned int k = 0; k < columns.size(); ++k)
      if (columns[k] >= block.begin && columns[k] < block.end)
        square += values[k] * values[k];
  }
  return std::sqrt(dealii::Utilities::MPI::sum(square, MPI_COMM_WORLD));
}

template <int dim>
void check(const bool is_tied)
{
  SceneModel<dim> scene_model(scene<dim>(is_tied));
  Model<dim> &model = scene_model.model;
  BlockSystem<dim> system(model);
  system.set_up(1.);
  Vector x = system.owned_vector();
  system.begin_step(1., x);
  system.assemble(x, true);

  double of_all = 0, of_one = 0, size = 0, smallest = 1e300;
  const auto &blocks = model.numbering->blocks();
  for (const std::string field : {"displacement", "temperature"}) {
    const unsigned int n_modes = field == "temperature" ? 1 : dim == 2 ? 3 : 6;
    bool has_modes = true;
    for (unsigned int mode = 0; mode < n_modes; ++mode) {
      Vector all = system.owned_vector(), product = system.owned_vector();
      for (unsigned int b = 0; b < blocks.size(); ++b)
        if (blocks[b].field == field) {
          Vector one = system.owned_vector();
          const auto with_others = model.near_null_space(blocks[b], true),
                     alone = model.near_null_space(blocks[b], false);
          has_modes = has_modes && with_others.size() == n_modes && alone.size() == n_modes;
          for (unsigned int i = 0; i < blocks[b].owned.n_elements(); ++i) {
            all(blocks[b].begin + blocks[b].owned.nth_index_in_set(i)) = with_others[mode][i];
            one(blocks[b].begin + blocks[b].owned.nth_index_in_set(i)) = alone[mode][i];
          }
          one.compress(dealii::VectorOperation::insert);
          system.tangent().vmult(product, one);
          of_one = std::max(of_one, product.l2_norm() / frobenius_norm(system, blocks[b]));
          size = std::max(size, one.linfty_norm());
          smallest = std::min(smallest, one.linfty_norm());
        }
      all.compress(dealii::VectorOperation::insert);
      system.tangent().vmult(product, all);
      of_all = std::max(of_all, product.l2_norm() / frobenius_norm(system, blocks[0]));
    }
    report(std::to_string(dim) + "D, " + std::to_string(n_modes) + " modes of the " + field, has_modes);
  }
  report("of both bodies", of_all, 1e-13);
  if (is_tied)
    report("a tied body alone cannot move", of_one > 1e-2);
  else
    report("of each body", of_one, 1e-13);
  report("largest entry of each between 0.3 and 1", size < 1 + 1e-12 && smallest > 0.3);
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  for (const bool is_tied : {false, true}) {
    check<2>(is_tied);
    check<3>(is_tied);
  }
}
