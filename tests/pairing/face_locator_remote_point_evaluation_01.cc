// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Where the sides touch, deal.II's Utilities::MPI::RemotePointEvaluation is another way to find the partner.
// The position, evaluated at the partners it found, agrees with the closest point.

// ranks: 1, 2, 3

#include "face_locator_queries.h"

#include <deal.II/base/mpi_remote_point_evaluation.h>
#include <deal.II/fe/fe_q.h>

using namespace dealii;

/// The positions X at the reference points that RemotePointEvaluation chose in the cells of the partner.
template <int dim>
std::vector<Point<dim>> evaluate_positions(const Utilities::MPI::RemotePointEvaluation<dim> &evaluation,
                                           const Triangulation<dim> &triangulation,
                                           const Mapping<dim> &mapping)
{
  std::vector<Point<dim>> buffer, result;
  const std::function<void(const ArrayView<Point<dim>> &,
                           const typename Utilities::MPI::RemotePointEvaluation<dim>::CellData &)>
      evaluate = [&](const auto &values, const auto &cell_data) {
        for (unsigned int i = 0; i < cell_data.cells.size(); ++i) {
          const typename Triangulation<dim>::cell_iterator cell(&triangulation, cell_data.cells[i].first,
                                                                cell_data.cells[i].second);
          for (auto q = cell_data.reference_point_ptrs[i]; q < cell_data.reference_point_ptrs[i + 1]; ++q)
            values[q] = mapping.transform_unit_to_real_cell(cell, cell_data.reference_point_values[q]);
        }
      };
  evaluation.template evaluate_and_process<Point<dim>>(result, buffer, evaluate);
  return result;
}

template <int dim>
void check(const std::string &name, const Triangulation<dim> &asking, const Triangulation<dim> &partner,
           const unsigned int degree)
{
  const MappingQ<dim> mapping(degree);
  const auto queries = locator_test::queries_of_side<dim>(asking, mapping, 1, QGauss<dim - 1>(2));
  std::vector<Point<dim>> points;
  for (const auto &query : queries)
    points.push_back(query.X);
  Utilities::MPI::RemotePointEvaluation<dim> evaluation(1e-6, true);
  evaluation.reinit(points, partner, mapping);
  const auto positions = evaluate_positions<dim>(evaluation, partner, mapping);

  const dovetail::FaceLocator<dim> locator(locator_test::faces_with(0, partner, mapping, degree), 0.2, 0.,
                                           MPI_COMM_WORLD);
  const auto matches = locator.locate(queries);
  unsigned int both = 0, only_one = 0, next = 0;
  double difference = 0;
  for (unsigned int i = 0; i < queries.size(); ++i) {
    const bool found = evaluation.get_point_ptrs()[i + 1] > evaluation.get_point_ptrs()[i];
    if (found && matches[i].found) {
      difference = std::max(difference, positions[next].distance(matches[i].X));
      ++both;
    }
    only_one += found != matches[i].found;
    next += found;
  }
  locator_test::print(name + ", degree " + std::to_string(degree) + ": both found " +
                      std::to_string(Utilities::MPI::sum(both, MPI_COMM_WORLD)) + ", only one " +
                      std::to_string(Utilities::MPI::sum(only_one, MPI_COMM_WORLD)) + ", equal " +
                      std::to_string(Utilities::MPI::max(difference, MPI_COMM_WORLD) < 1e-10));
}

template <int dim>
void check()
{
  parallel::distributed::Triangulation<dim> left(MPI_COMM_WORLD), right(MPI_COMM_WORLD);
  Point<dim> origin, end;
  for (unsigned int d = 0; d < dim; ++d)
    end[d] = 1;
  GridGenerator::subdivided_hyper_rectangle(left, std::vector<unsigned int>(dim, 5), origin, end, true);
  GridGenerator::subdivided_hyper_rectangle(right, std::vector<unsigned int>(dim, 3), origin, end, true);
  right.refine_global(1);
  GridTools::shift(Point<dim>::unit_vector(0), right);
  for (const unsigned int degree : {1, 2})
    check<dim>(std::to_string(dim) + "D", left, right, degree);
}

int main(int argc, char *argv[])
{
  Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check<2>();
  check<3>();
}
