// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/pairing/region.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

using dealii::Point;
using dealii::Tensor;

double cross(const Tensor<1, 2> &a, const Tensor<1, 2> &b)
{
  return a[0] * b[1] - a[1] * b[0];
}

namespace {

constexpr double tolerance = 1e-14;

double signed_area(const Region<2> &corners)
{
  double twice = 0;
  for (unsigned int i = 2; i < corners.size(); ++i)
    twice += cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
  return twice / 2;
}

/// The part on the left (sign = 1) or right (-1) of the line from a to b. A corner that is on the line up to
/// rounding belongs to both parts.
Region<2> half(const Region<2> &subject, const Point<2> &a, const Point<2> &b, const double sign)
{
  const Tensor<1, 2> along = (b - a) / b.distance(a);
  std::vector<double> distance;
  for (const Point<2> &corner : subject) {
    const double d = sign * cross(along, corner - a);
    distance.push_back(std::abs(d) <= tolerance ? 0. : d);
  }
  Region<2> inside;
  for (unsigned int i = 0; i < subject.size(); ++i) {
    const unsigned int next = (i + 1) % subject.size();
    if (distance[i] >= 0)
      inside.push_back(subject[i]);
    if (distance[i] * distance[next] < 0) {
      const double share = distance[i] / (distance[i] - distance[next]);
      inside.push_back(subject[i] + share * (subject[next] - subject[i]));
    }
  }
  return inside;
}

/// Without corners that coincide or lie on the straight line between their neighbours.
Region<2> tidy(const Region<2> &region)
{
  Region<2> result;
  for (const Point<2> &corner : region)
    if (result.empty() || corner.distance(result.back()) > tolerance)
      result.push_back(corner);
  while (result.size() > 1 && result.front().distance(result.back()) <= tolerance)
    result.pop_back();
  for (unsigned int i = 0; i < result.size() && result.size() > 3;) {
    const Point<2> &last = result[(i + result.size() - 1) % result.size()];
    const Tensor<1, 2> along = result[(i + 1) % result.size()] - last;
    if (std::abs(cross(along, result[i] - last)) <= tolerance * along.norm())
      result.erase(result.begin() + i);
    else
      ++i;
  }
  if (result.size() < 3 || std::abs(signed_area(result)) <= tolerance * tolerance)
    return {};
  return result;
}

} // namespace

double measure(const Region<1> &region)
{
  return region.empty() ? 0. : region[1][0] - region[0][0];
}

double measure(const Region<2> &region)
{
  return signed_area(region);
}

Point<1> centroid(const Region<1> &region)
{
  return Point<1>((region[0][0] + region[1][0]) / 2);
}

Point<2> centroid(const Region<2> &region)
{
  Tensor<1, 2> sum;
  double twice = 0;
  for (unsigned int i = 2; i < region.size(); ++i) {
    const Tensor<1, 2> a = region[i - 1] - region[0], b = region[i] - region[0];
    sum += cross(a, b) * (a + b) / 3;
    twice += cross(a, b);
  }
  return region[0] + sum / twice;
}

Region<1> oriented(Region<1> corners)
{
  if (corners[0][0] > corners[1][0])
    std::swap(corners[0], corners[1]);
  return corners;
}

Region<2> oriented(Region<2> corners)
{
  if (signed_area(corners) < 0)
    std::reverse(corners.begin(), corners.end());
  return corners;
}

Region<1> clip(const Region<1> &subject, const Region<1> &window)
{
  const double begin = std::max(subject[0][0], window[0][0]), end = std::min(subject[1][0], window[1][0]);
  if (end - begin <= tolerance)
    return {};
  return {Point<1>(begin), Point<1>(end)};
}

Region<2> clip(const Region<2> &subject, const Region<2> &window)
{
  for (unsigned int d = 0; d < 2; ++d) {
    const auto less = [d](const Point<2> &a, const Point<2> &b) { return a[d] < b[d]; };
    const auto [first, last] = std::minmax_element(subject.begin(), subject.end(), less);
    const auto [begin, end] = std::minmax_element(window.begin(), window.end(), less);
    if ((*last)[d] - (*begin)[d] <= tolerance || (*end)[d] - (*first)[d] <= tolerance)
      return {};
  }
  Region<2> result = subject;
  for (unsigned int i = 0; i < window.size() && !result.empty(); ++i)
    if (const Point<2> &a = window[i], &b = window[(i + 1) % window.size()]; a.distance(b) > tolerance)
      result = half(result, a, b, 1);
  return tidy(result);
}

std::vector<Region<1>> subtract(const Region<1> &region, const Region<1> &hole)
{
  std::vector<Region<1>> parts;
  if (hole[0][0] - region[0][0] > tolerance)
    parts.push_back({region[0], Point<1>(std::min(hole[0][0], region[1][0]))});
  if (region[1][0] - hole[1][0] > tolerance)
    parts.push_back({Point<1>(std::max(hole[1][0], region[0][0])), region[1]});
  return parts;
}

std::vector<Region<2>> subtract(const Region<2> &region, const Region<2> &hole)
{
  if (clip(region, hole).empty())
    return {region};
  std::vector<Region<2>> parts;
  Region<2> rest = region;
  for (unsigned int i = 0; i < hole.size() && !rest.empty(); ++i)
    if (const Point<2> &a = hole[i], &b = hole[(i + 1) % hole.size()]; a.distance(b) > tolerance) {
      Region<2> outside = tidy(half(rest, a, b, -1));
      if (!outside.empty())
        parts.push_back(std::move(outside));
      rest = half(rest, a, b, 1);
    }
  return parts;
}

} // namespace dovetail
