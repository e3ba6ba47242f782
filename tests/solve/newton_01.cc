// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Newton's method for one unknown. Quadratic: x^2 - 2 from 1.5, where e_(k+1) = e_k^2 / (2 x_k), by hand.
// Line search: log(x) from 5, whose full update leaves the domain of the logarithm, and exp(x) - 1 from -6,
// whose full update of 402 would make the residual grow by 1e174, so it is not trusted. exp(5 x) has no zero,
// but its residual vanishes as x runs off: its updates never become small. A failure is a status, not an
// exception. Beyond a limit point: x^3 - 3 x + 3 from 1.6, where nothing but the root at -2.1038 is left;
// with and without what stabilises. x + 1000 x^3 - 36 from 0: the first update of 36 is a hundred times too
// far.

#include <dovetail/scene/scene_text.h>
#include <dovetail/solve/newton.h>

#include <cmath>
#include <functional>
#include <iomanip>
#include <iostream>
#include <utility>

using namespace dovetail;

/// f(x) = 0 from x, and what Newton's method asks for.
struct Toy : NonlinearProblem
{
  Toy(std::function<double(double)> f, std::function<double(double)> slope, double x)
      : f(f), slope(slope), x(x)
  {
  }

  std::function<double(double)> f, slope;
  double x;
  bool is_affine = false, moves = false, overshoots = false, hides_load = false;
  Newton::Start start = Newton::Start::nearby;
  double adapts_to = 0; ///< if not 0: the factor of the equation after the first full update
  double residual_of_solver = 0;
  double slope_at_rest = 0;     ///< if not 0: what stabilises
  unsigned int fails_at = 1000; ///< number of the solve that fails
  unsigned int n_solves = 0, n_assemblies = 0, n_tangents = 0;
  std::vector<double> dampings;

  double R = 0, tangent = 0, solved_with = 0, factor = 1, share = 0;

  bool is_linear() const override { return is_affine; }
  double residual(const Vector &x) override
  {
    ++n_assemblies;
    tangent = 0; // that was not asked for is of no use
    R = factor * f(x(0));
    return std::abs(R);
  }
  double residual_and_tangent(const Vector &x) override
  {
    const double size = residual(x);
    ++n_tangents;
    tangent = factor * slope(x(0));
    return size;
  }
  std::optional<unsigned int> solve(const Vector &, Vector &dx) override
  {
    if (++n_solves == fails_at)
      return {};
    solved_with = tangent + std::exchange(share, 0) * slope_at_rest;
    dx = -R / solved_with;
    return 3;
  }
  bool may_overshoot() const override { return overshoots && std::abs(R) > 3; }
  bool has_hidden_load() const override { return hides_load; }
  double linear_residual() const override { return residual_of_solver; }
  bool moves_constraints() const override { return moves; }
  bool correct(const Vector &, const Vector &, double, Vector &correction) override
  {
    correction = -R / (tangent != 0 ? tangent : solved_with);
    return true;
  }
  double norm(const Vector &dx) const override { return std::abs(dx(0)); }
  bool is_small(const Vector &dx, const Vector &x) const override
  {
    return norm(dx) <= 1e-3 * std::max(1., std::abs(x(0) - dx(0)));
  }
  bool adapt(const Vector &) override { return adapts_to != 0 && std::exchange(factor, adapts_to) == 1; }
  bool may_cross_limit_points() const override { return slope_at_rest != 0; }
  bool stabilise(const Vector &, const double share_of_rest) override
  {
    share = share_of_rest;
    return true;
  }
  void iteration_ends(unsigned int, double, unsigned int, const double damping) override
  {
    dampings.push_back(damping);
  }

  NewtonResult find_root(const std::string &settings = "")
  {
    Vector vector({dealii::complete_index_set(1)}, MPI_COMM_WORLD);
    vector = x;
    const auto result = Newton(SceneText::root(SceneText::from_prm(settings))).solve(*this, vector, start);
    x = vector(0);
    return result;
  }
};

void show(const std::string &name, Toy toy, const std::string &settings = "")
{
  const NewtonResult result = toy.find_root(settings);
  std::cout << name << ": " << (result.is_converged ? "converged" : "failed") << ", x " << toy.x
            << ", residuals " << result.residuals.size() << ", linear iterations";
  for (const unsigned int n : result.linear_iterations)
    std::cout << ' ' << n;
  std::cout << ", assemblies " << toy.n_assemblies << " with tangent " << toy.n_tangents << ", dampings";
  for (const double damping : toy.dampings)
    std::cout << ' ' << damping;
  std::cout << std::endl;
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  std::cout << std::setprecision(6);
  const double nan = std::nan("");
  const Toy root = {[](double x) { return x * x - 2; }, [](double x) { return 2 * x; }, 1.5};
  const Toy logarithm = {[](double x) { return std::log(x); }, [](double x) { return 1 / x; }, 5};
  const Toy exponential = {[](double x) { return std::exp(x) - 1; }, [](double x) { return std::exp(x); },
                           -6};

  show("quadratic", root);
  Toy toy = root;
  const auto residuals = toy.find_root("set Relative tolerance = 1e-13").residuals;
  std::cout << "e_k+1 / e_k^2 * 2 x_k";
  double x = 1.5;
  for (unsigned int k = 0; k + 2 < residuals.size(); ++k) {
    // f = e (2 sqrt 2 + e)
    const auto error = [](const double f) { return std::sqrt(2 + f) - std::sqrt(2.); };
    std::cout << ' ' << error(residuals[k + 1]) / std::pow(error(residuals[k]), 2) * 2 * x;
    x = x / 2 + 1 / x;
  }
  std::cout << std::endl;

  show("logarithm", logarithm);
  show("logarithm without line search", logarithm, "set Line search = false");
  show("exponential", exponential);
  toy = exponential;
  toy.x = -1; // the full update of 1.7 makes the residual grow by less than 2
  show("exponential, nearer", toy);
  toy.start = Newton::Start::guess;
  show("exponential, nearer, from a guess", toy);
  toy = exponential;
  toy.adapts_to = 2; // as many times the equation from then on
  show("exponential, adapted", toy);
  show("too few iterations", root, "set Maximum iterations = 2");

  toy = root;
  toy.fails_at = 2;
  show("the second solve fails", toy);
  toy = root;
  toy.f = [](double) { return std::nan(""); };
  show("not defined at the start", toy);
  toy = root;
  toy.f = [nan](const double x) { return x == 1.5 ? 1. : nan; };
  show("not defined anywhere else", toy);
  toy = Toy([](double x) { return std::exp(5 * x); }, [](double x) { return -std::exp(5 * x); }, 0);
  show("an update that leads away", toy);

  show("no zero",
       Toy([](double x) { return std::exp(5 * x); }, [](double x) { return 5 * std::exp(5 * x); }, 0));

  toy = Toy([](double x) { return 4 * x - 2; }, [](double) { return 4.; }, 7);
  toy.is_affine = true;
  toy.residual_of_solver = 1e-11;
  show("linear", toy);
  toy.x = 0.5;
  show("already solved", toy);
  toy.moves = true;
  show("already solved, but prescribed values move", toy);
  toy = logarithm;
  toy.x = 2;
  toy.moves = true;
  show("no damping while prescribed values move", toy, "set Maximum iterations = 1");
  toy.moves = false;
  toy.hides_load = true;
  toy.x = 1;
  show("already solved, but rounding may hide a load", toy);
  toy = Toy([](double x) { return x + 1000 * x * x * x - 36; }, [](double x) { return 1 + 3000 * x * x; }, 0);
  show("stiffens", toy);
  toy.overshoots = true;
  show("stiffens, does not overshoot", toy);
  toy = {[](double x) { return x * x * x - 3 * x + 3; }, [](double x) { return 3 * x * x - 3; }, 1.6};
  show("limit point", toy);
  toy.slope_at_rest = 3;
  show("limit point, stabilised", toy);
}
