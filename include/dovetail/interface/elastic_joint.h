// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a tie says of a joint through which its sides come apart.

#pragma once

#include <dovetail/interface/tie.h>

namespace dovetail {

class ElasticJoint
{
public:
  virtual ~ElasticJoint() = default;
  /// Whether at time @p t it surely resists every motion of one side against the other, rotations too.
  virtual bool surely_holds(const TiedField &field, double t) const = 0;
};

} // namespace dovetail
