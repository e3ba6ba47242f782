// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The points of a pairing: areas and covered areas by hand in every comment below (with mapped points a side
// that ends inside a face is covered up to its quadrature points only), number of points and of groups (pairs
// of cells). At every point: the normals are opposite on flat sides, the shape functions sum to 1 and their
// gradients to 0, values and gradients of an affine field are exact on both sides, and its jump over a gap
// vanishes with the gap extension and is the gradient times the gap without.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/interface/side_points.h>

using namespace test;

struct Case
{
  std::string name, left, right; ///< the bodies: Degree and Mesh
  std::string source, destination, entries;
  std::string clamped = "2"; ///< boundary id of the left body
};

template <int dim>
std::string scene(const Case &of)
{
  return set("Materials", "steel") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material steel",
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "1") +
                                            set("Poisson ratio", "0.3"))) +
         subsection("Domain left", set("Material", "steel") + set("Boundary conditions", "clamp") +
                                       subsection("Boundary condition clamp",
                                                  set("Type", "value") + set("Field", "displacement") +
                                                      set("Boundary ids", of.clamped) +
                                                      set("Expression", dim == 2 ? "0; 0" : "0; 0; 0")) +
                                       of.left) +
         subsection("Domain right", set("Material", "steel") + of.right) +
         subsection("Interface seam", set("Type", "Nitsche") + set("Source", of.source) +
                                          set("Destination", of.destination) + of.entries);
}

template <int dim>
void check(const Case &of)
{
  SceneModel<dim> scene_model(scene<dim>(of));
  Model<dim> &model = scene_model.model;
  const Interface<dim> &interface = *model.interfaces[0];
  const Pairing<dim> &pairing = interface.pairing();

  dealii::Tensor<2, dim> A;
  dealii::Tensor<1, dim> b;
  for (unsigned int c = 0; c < dim; ++c) {
    b[c] = 1 + c;
    for (unsigned int d = 0; d < dim; ++d)
      A[c][d] = noise(c * dim + d);
  }
  const auto u = [&](const dealii::Point<dim> &X) { return b + A * X; };
  Vector owned = BlockSystem<dim>(model).owned_vector();
  interpolate<dim>(
      model, [&](unsigned int, const unsigned int c, const dealii::Point<dim> &X) { return u(X)[c]; }, owned);
  const std::vector<double> all = gather(model, owned);

  bool groups_follow = true;
  unsigned int next = 0;
  double opposite = 0, partition = 0, affine = 0, extension = 0, area = 0;
  SidePoints<dim> points(interface, 0);
  std::vector<double> jump;
  for (const auto &group : pairing.groups) {
    groups_follow = groups_follow && group.begin == next && group.end > group.begin;
    next = group.end;
    const std::vector<double> unknowns = of_group(interface, group, all);
    for (unsigned int q = group.begin; q < group.end; ++q) {
      area += pairing.weight(q);
      opposite = std::max(opposite, (pairing.N(source, q) + pairing.N(destination, q)).norm());
      dealii::Tensor<1, dim> expected_jump;
      if (interface.gap_extension() == GapExtension::none)
        expected_jump = A * (pairing.X(source, q) - pairing.X(destination, q));
      interface.jump(interface.fields[0], q, 0, unknowns, jump);
      dealii::Tensor<1, dim> jump_of_test = b * 0.;
      for (unsigned int c = 0; c < dim; ++c)
        extension = std::max(extension, std::abs(jump[c] - expected_jump[c]));

      for (const unsigned int side : {source, destination}) {
        points.reinit(side, q, unknowns);
        const State<dim> &state = points.state[side];
        const auto expected = u(pairing.X(side, q));
        for (unsigned int c = 0; c < dim; ++c)
          affine =
              std::max({affine, std::abs(state.value[c] - expected[c]), (state.gradient[c] - A[c]).norm()});
        const unsigned int n = interface.sides[side].domain->n_nodes();
        double values = 0, trial = 0;
        dealii::Tensor<1, dim> gradients;
        for (unsigned int a = 0; a < n; ++a) {
          values += pairing.values(side, q)[a];
          trial += pairing.trial(side, q, 0)[a];
          gradients += pairing.gradients(side, q)[a];
          for (unsigned int c = 0; c < dim; ++c)
            jump_of_test[c] += (side == source ? 1 : -1) * pairing.test(side, q, 0)[a] *
                               unknowns[(side == source ? 0 : interface.n_local(source)) + c * n + a];
        }
        partition = std::max({partition, std::abs(values - 1), std::abs(trial - 1), gradients.norm()});
      }
      if (interface.gap_extension() != GapExtension::symmetric)
        jump_of_test -= A * (pairing.X(source, q) - pairing.X(destination, q));
      extension = std::max(extension, jump_of_test.norm());
    }
  }
  groups_follow = groups_follow && next == pairing.n_points();

  const Coverage &coverage = pairing.coverage();
  if (is_rank_0())
    std::cout << of.name << std::endl;
  print("  areas, covered", {coverage.area[0], coverage.area[1], coverage.covered[0], coverage.covered[1]});
  print("  weights, points, uncovered, groups",
        {dealii::Utilities::MPI::sum(area, MPI_COMM_WORLD), double(coverage.n_points),
         double(coverage.n_uncovered),
         double(dealii::Utilities::MPI::sum(pairing.groups.size(), MPI_COMM_WORLD))});
  print("  gap, angle", {coverage.largest_gap, coverage.largest_angle});
  report("  groups", groups_follow);
  // on curved sides: within the largest angle
  report("  normals", opposite, 1e-13 + 2 * std::sin(coverage.largest_angle / 2) * (1 + 1e-6));
  report("  sums of shape functions", partition, 1e-12);
  report("  affine field", affine, 1e-12);
  report("  jump", extension, 1e-12);
}

/// `Degree` and `Mesh` of a box, and of a ring of n cells.
std::string body(const std::string &arguments, const unsigned int degree = 1)
{
  return set("Degree", std::to_string(degree)) + box(arguments);
}

std::string ring(const std::string &radii, const std::string &n, const unsigned int degree)
{
  return set("Degree", std::to_string(degree)) +
         subsection("Mesh", set("Generator", "hyper_shell") +
                                set("Arguments", "0, 0 : " + radii + " : " + n + " : true"));
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string from = set("Integrate on", "source"), to = set("Integrate on", "destination"),
                    both = set("Integrate on", "both"), l = "left : 1", r = "right : 0";

  // length 1; 3 + 4 faces make 6 pairs; points per face: 2 + 1, on the coarse side ceil(2 * 4/3) + 1
  const std::string three = body("2, 3 : 0, 0 : 1, 1"), four = body("2, 4 : 1, 0 : 2, 1");
  const std::string mapped = set("Quadrature", "mapped points");
  check<2>({"3 : 4, mapped on source", three, four, l, r, from + mapped});
  check<2>({"3 : 4, mapped on destination", three, four, l, r, to + mapped});
  check<2>({"3 : 4, mapped on both", three, four, l, r, both + mapped});
  check<2>({"3 : 4, source", three, four, l, r, from});
  check<2>({"3 : 4, destination", three, four, l, r, to});
  check<2>({"3 : 4, both", three, four, l, r, both});

  // a gap of 0.02
  const std::string apart = body("2, 4 : 1.02, 0 : 2, 1", 2);
  check<2>({"gap, symmetric", three, apart, l, r, from});
  check<2>({"gap, trial", three, apart, l, r, both + set("Gap extension", "trial")});
  check<2>({"gap, none", three, apart, l, r, to + set("Gap extension", "none")});

  // 1 against 1/2, which begins and ends at faces of the other side; then 1 against 1, shifted by half
  const std::string whole = body("2, 4 : 0, 0 : 1, 1"), half = body("2, 3 : 1, 0.25 : 2, 0.75"),
                    shifted = body("2, 4 : 1, 0.5 : 2, 1.5"), allow = set("Uncovered", "allow");
  check<2>({"the source is larger", whole, half, l, r, from});
  check<2>({"the destination is larger", half, whole, "left : 0", "right : 1", from});
  check<2>({"integrated on the smaller side", whole, half, l, r, to});
  check<2>({"both overhang", whole, shifted, l, r, both + allow});
  // the larger side ends inside a face
  check<2>({"inside a face", body("2, 3 : 0, 0 : 1, 1"), half, l, r, from});
  check<2>({"mapped points inside a face", body("2, 3 : 0, 0 : 1, 1"), half, l, r,
            from + mapped + set("Points per face", "20")});

  // 2 pi
  check<2>({"rings, degree 1", ring("0.5 : 1", "24", 1), ring("1 : 1.5", "36", 1), l, r, from, "0"});
  check<2>({"rings, degree 2", ring("0.5 : 1", "12", 2), ring("1 : 1.5", "18", 2), l, r, both, "0"});

  // 1 in 3D; 2 * 2 against 3 * 3 faces make 4 * 4 pairs
  const std::string cube = body("1, 2, 2 : 0, 0, 0 : 1, 1, 1"), next = body("1, 3, 3 : 1.01, 0, 0 : 2, 1, 1");
  check<3>({"cubes", cube, next, l, r, from});
  check<3>({"cubes, degree 2", cube, body("1, 1, 3 : 1.01, 0, 0 : 2, 1, 1", 2), l, r, to});
}
