// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// At the points of an interface, the traces and gradients of functions that follow others are those of their
// leaders times a factor: on boxes, in curved cells, across a gap, and of each side's own degree; and there
// are as many leaders as two nodes for each node of a face. Triangles have none.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

using namespace test;

namespace {

struct Case
{
  std::string name, left, right, source, destination;
  bool has_followers = true;
};

template <int dim>
void check(const Case &of, const unsigned int degree)
{
  const std::string laws = subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                                   set("Poisson ratio", "0.3"));
  const auto body = [](const std::string &mesh, const unsigned int p) {
    return set("Material", "one") + set("Degree", std::to_string(p)) + mesh;
  };
  const std::string held =
      set("Boundary conditions", "held") +
      subsection("Boundary condition held", set("Type", "value") + set("Field", "displacement") +
                                                set("Boundary ids", "0") +
                                                set("Expression", dim == 2 ? "0; 0" : "0; 0; 0"));
  SceneModel<dim> scene_model(set("Materials", "one") + set("Domains", "left, right") +
                              set("Interfaces", "seam") + subsection("Material one", laws) +
                              subsection("Domain left", body(of.left, degree) + held) +
                              subsection("Domain right", body(of.right, degree + 1)) +
                              subsection("Interface seam", set("Type", "Nitsche") + set("Source", of.source) +
                                                               set("Destination", of.destination)));
  const Interface<dim> &interface = *scene_model.model.interfaces[0];
  const Pairing<dim> &pairing = interface.pairing();
  double error = 0;
  bool has_count = true;
  for (const auto &group : pairing.groups) {
    const LeadingUnknowns &leading = interface.leading_unknowns(group);
    unsigned int first = 0;
    for (const unsigned int side : {source, destination}) {
      const auto &layout = interface.sides[side].domain->layout();
      const unsigned int n_nodes = layout.n_nodes(0),
                         n_on_face = std::lround(std::pow(degree + 1 + side, dim - 1)),
                         n_leading = of.has_followers ? dim * 2 * n_on_face : dim * n_nodes;
      has_count = has_count && leading.n_of_side[side] == n_leading;
      for (unsigned int c = 0; c < dim; ++c)
        for (unsigned int a = 0; a < n_nodes; ++a) {
          const unsigned int i = first + c * n_nodes + a;
          const unsigned int leader = leading.nodes[side][c][leading.leader[i] - leading.first[side][c]];
          for (unsigned int q = group.begin; q < group.end; ++q) {
            const double *values = pairing.values(side, q), *trial = pairing.trial(side, q, 0);
            const dealii::Tensor<1, dim> *gradients = pairing.gradients(side, q);
            const double h = std::pow(pairing.cells[side][group.cells[side]].cell_measure, 1. / dim);
            error = std::max({error, std::abs(values[a] - leading.factor[i] * values[leader]),
                              std::abs(trial[a] - leading.factor[i] * trial[leader]),
                              h * (gradients[a] - leading.factor[i] * gradients[leader]).norm()});
          }
        }
      first += dim * n_nodes;
    }
  }
  const std::string name = of.name + ", degree " + std::to_string(degree);
  report(name + ", traces and gradients", error, 1e-11);
  report(name + ", number", has_count);
}

std::string shell(const std::string &arguments)
{
  return subsection("Mesh", set("Generator", "hyper_shell") + set("Arguments", arguments + " : true"));
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string simplices = set("Cells", "simplices");
  for (const unsigned int degree : {2, 3}) {
    check<2>({"boxes", box("2, 2 : 0, 0 : 1, 1"), box("1, 3 : 1, 0 : 1.5, 1"), "left : 1", "right : 0"},
             degree);
    check<3>({"boxes in 3D", box("1, 2, 2 : 0, 0, 0 : 1, 1, 1"), box("1, 3, 1 : 0, 1, 0 : 1, 2, 1"),
              "left : 3", "right : 2"},
             degree);
    check<2>({"gap", box("2, 2 : 0, 0 : 1, 1"), box("1, 3 : 1.01, 0 : 1.5, 1"), "left : 1", "right : 0"},
             degree);
    check<2>({"rings", shell("0, 0 : 0.5 : 1 : 6"), shell("0, 0 : 1 : 1.5 : 9"), "left : 1", "right : 0"},
             degree);
  }
  check<3>(
      {"shells", shell("0, 0, 0 : 0.5 : 1 : 6"), shell("0, 0, 0 : 1 : 1.5 : 12"), "left : 1", "right : 0"},
      2);
  check<2>({"triangles", box("2, 2 : 0, 0 : 1, 1", simplices), box("1, 3 : 1, 0 : 1.5, 1", simplices),
            "left : 1", "right : 0", false},
           1);
}
