// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Clipping and subtracting convex regions: areas by hand for the cases that break clippers (flush edges,
// T-junctions, a corner on an edge, a common edge, slivers), and for random triangles and quadrilaterals the
// sums |A| = |A and B| + |A without B|, |A and B| = |B and A|, and that the parts do not overlap B.

#include <dovetail/pairing/region.h>

#include <cmath>
#include <iostream>
#include <numeric>

using namespace dovetail;
using dealii::Point;

double noise(const unsigned long i)
{
  return std::fmod(std::abs(std::sin(12.9898 * (i + 1.)) * 43758.5453), 1.);
}

template <int dim>
double sum(const std::vector<Region<dim>> &parts)
{
  return std::accumulate(parts.begin(), parts.end(), 0.,
                         [](const double sum, const Region<dim> &part) { return sum + measure(part); });
}

template <int dim>
void check(const std::string &name, const Region<dim> &subject, const Region<dim> &window)
{
  const Region<dim> common = clip(subject, window);
  std::cout << name << ": " << common.size() << " corners, " << measure(common) << ", outside "
            << sum<dim>(subtract(subject, window)) << std::endl;
}

/// A square with its lower left corner there.
Region<2> square(const double x, const double y, const double size = 1)
{
  return {Point<2>(x, y), Point<2>(x + size, y), Point<2>(x + size, y + size), Point<2>(x, y + size)};
}

Region<2> random_polygon(const unsigned int seed)
{
  const unsigned int n = 3 + seed % 2;
  const Point<2> centre(noise(10 * seed), noise(10 * seed + 1));
  Region<2> result;
  for (unsigned int i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * (i + 0.5 * noise(10 * seed + 2 + i)) / n;
    result.push_back(centre + 0.7 * dealii::Tensor<1, 2>({std::cos(angle), std::sin(angle)}));
  }
  return result;
}

int main()
{
  check<1>("inside", {Point<1>(0.2), Point<1>(0.5)}, {Point<1>(0.), Point<1>(1.)});
  check<1>("around", {Point<1>(0.), Point<1>(1.)}, {Point<1>(0.2), Point<1>(0.5)});
  check<1>("touching", {Point<1>(0.), Point<1>(1.)}, {Point<1>(1.), Point<1>(2.)});
  check<1>("apart", {Point<1>(0.), Point<1>(1.)}, {Point<1>(3.), Point<1>(4.)});

  check<2>("the same", square(0, 0), square(0, 0));
  check<2>("a common edge", square(0, 0), square(1, 0));
  check<2>("a common corner", square(0, 0), square(1, 1));
  check<2>("apart", square(0, 0), square(2, 0.5));
  check<2>("flush edges", square(0, 0), square(0.25, 0, 0.5));
  check<2>("T-junction", square(0, 0), square(0.5, -0.5));
  check<2>("inside", square(0, 0), square(0.25, 0.25, 0.5));
  check<2>("around", square(0.25, 0.25, 0.5), square(0, 0));
  check<2>("a corner on an edge", square(0, 0),
           {Point<2>(0.5, 0), Point<2>(1.5, 1), Point<2>(0.5, 2), Point<2>(-0.5, 1)});
  const double width = 1e-9;
  std::cout << "sliver: " << measure(clip(square(0, 0), square(1 - width, 0))) / width << std::endl;
  check<2>("offset by rounding", square(0, 0), square(1e-16, 1e-16));

  double of_parts = 0, of_order = 0, of_overlap = 0, of_centroid = 0;
  unsigned int n_overlapping = 0;
  for (unsigned int i = 0; i < 200; ++i) {
    const Region<2> a = random_polygon(2 * i), b = random_polygon(2 * i + 1);
    const Region<2> common = clip(a, b);
    const auto outside = subtract(a, b);
    n_overlapping += common.empty() ? 0 : 1;
    of_parts = std::max(of_parts, std::abs(measure(common) + sum<2>(outside) - measure(a)));
    of_order = std::max(of_order, std::abs(measure(common) - measure(clip(b, a))));
    dealii::Tensor<1, 2> moment = -measure(a) * centroid(a);
    if (!common.empty())
      moment += measure(common) * centroid(common);
    for (const auto &part : outside) {
      of_overlap = std::max(of_overlap, measure(clip(part, b)));
      moment += measure(part) * centroid(part);
    }
    of_centroid = std::max(of_centroid, moment.norm());
  }
  std::cout << n_overlapping << " of 200 random pairs overlap" << std::endl;
  const auto report = [](const std::string &what, const double error) {
    std::cout << what << (error < 1e-13 ? ": ok" : ": error " + std::to_string(error)) << std::endl;
  };
  report("area of the parts", of_parts);
  report("order", of_order);
  report("overlap", of_overlap);
  report("first moments", of_centroid);
}
