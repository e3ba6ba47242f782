// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The numbering [u_left T_left | T_middle | u_right]: the sizes of the blocks by hand, one after another
// without holes; every unknown has one owner, whom all ranks know; in a block each rank owns one range; the
// unknowns of a cell stand in the order component, node, each in the block of its field; split() gives every
// index once. The middle has one cell only, fewer than ranks.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

using namespace test;

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string solid = subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                                    set("Poisson ratio", "0.3")),
                    heat = subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1"));
  const auto held = [](const std::string &field, const std::string &zero) {
    return subsection("Boundary condition " + field, set("Type", "value") + set("Field", field) +
                                                         set("Boundary ids", "0") + set("Expression", zero));
  };
  const std::string u = held("displacement", "0; 0"), T = held("temperature", "0");
  SceneModel<2> scene_model(
      set("Materials", "both, heat, solid") + set("Domains", "left, middle, right") +
      subsection("Material both", solid + heat) + subsection("Material heat", heat) +
      subsection("Material solid", solid) +
      subsection("Domain left", set("Material", "both") +
                                    set("Boundary conditions", "displacement, temperature") + u + T +
                                    box("5, 4 : 0, 0 : 1, 1")) +
      subsection("Domain middle", set("Material", "heat") + set("Degree", "3") +
                                      set("Boundary conditions", "temperature") + T +
                                      box("1, 1 : 1, 0 : 2, 1")) +
      subsection("Domain right", set("Material", "solid") + set("Degree", "2") +
                                     set("Boundary conditions", "displacement") + u +
                                     box("2, 3 : 2, 0 : 3, 1")));
  const Model<2> &model = scene_model.model;
  const Numbering &numbering = *model.numbering;
  const unsigned int rank = dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD);

  // left 6 * 5 nodes, middle 4 * 4, right 5 * 7
  bool follow = true, know = true;
  dealii::types::global_dof_index next = 0;
  for (const Block &block : numbering.blocks()) {
    print(block.name + " " + block.field, {double(block.end - block.begin)});
    follow = follow && block.begin == next && model.domains[block.domain_index]->name == block.name &&
             model.domains[block.domain_index]->fields()[block.field_index].name == block.field;
    next = block.end;
    know = know && block.owned.size() == block.end - block.begin && block.owned.is_contiguous() &&
           block.first_of_rank.back() == block.owned.size() &&
           block.owned.n_elements() == block.first_of_rank[rank + 1] - block.first_of_rank[rank] &&
           (block.owned.n_elements() == 0 || block.owned.nth_index_in_set(0) == block.first_of_rank[rank]);
  }
  report("blocks follow each other", follow && next == numbering.n_dofs());
  report("ranges of the ranks", know);

  std::vector<unsigned int> owners(numbering.n_dofs(), 0), count(numbering.n_dofs(), 0);
  for (const auto dof : numbering.owned) {
    owners[dof] = rank;
    count[dof] = 1;
  }
  dealii::Utilities::MPI::sum(owners, MPI_COMM_WORLD, owners);
  dealii::Utilities::MPI::sum(count, MPI_COMM_WORLD, count);
  bool one_owner = true, right_block = true, owned_is_relevant = true;
  for (unsigned int dof = 0; dof < numbering.n_dofs(); ++dof) {
    one_owner = one_owner && count[dof] == 1 && numbering.owner(dof) == owners[dof];
    const Block &block = numbering.blocks()[numbering.block_of(dof)];
    right_block = right_block && block.begin <= dof && dof < block.end;
    owned_is_relevant =
        owned_is_relevant && (!numbering.owned.is_element(dof) || numbering.relevant.is_element(dof));
  }
  report("one owner", one_owner);
  report("block of each", right_block);
  report("owned unknowns are relevant", owned_is_relevant);

  bool ordered = true;
  double far = 0;
  std::map<dealii::types::global_dof_index, dealii::Point<2>> place;
  std::vector<dealii::types::global_dof_index> dofs;
  for (unsigned int d = 0; d < model.domains.size(); ++d) {
    const Domain<2> &domain = *model.domains[d];
    dealii::FEValues<2> at_nodes(domain.mapping(), domain.scalar_element(),
                                 domain.scalar_element().get_unit_support_points(),
                                 dealii::update_quadrature_points);
    for (const auto &cell : domain.dof_handler().active_cell_iterators())
      if (!cell->is_artificial()) {
        domain.cell_dofs(cell, dofs);
        at_nodes.reinit(dealii::Triangulation<2>::active_cell_iterator(cell));
        for (unsigned int i = 0; i < dofs.size(); ++i) {
          const unsigned int component = i / domain.layout().n_nodes(0);
          const Block &block = numbering.blocks()[numbering.block_of(dofs[i])];
          const Field &field = domain.fields()[block.field_index];
          ordered = ordered && block.domain_index == d && component >= field.first_component &&
                    component < field.first_component + field.n_components &&
                    numbering.relevant.is_element(dofs[i]);
          // the same unknown in two cells: the same node and component
          const dealii::Point<2> X = at_nodes.quadrature_point(i % domain.layout().n_nodes(0)) +
                                     dealii::Point<2>(10. * component, 0);
          far = std::max(far, X.distance(place.emplace(dofs[i], X).first->second));
        }
      }
  }
  report("order component, node", ordered);
  report("one place for each unknown", far, 1e-13);

  const auto parts = numbering.split(numbering.relevant);
  dealii::IndexSet together(numbering.n_dofs());
  for (unsigned int b = 0; b < parts.size(); ++b)
    together.add_indices(parts[b], numbering.blocks()[b].begin);
  report("split", together == numbering.relevant);
}
