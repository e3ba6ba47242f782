// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The progress bar at shares that there should not be as well: n + 2 of n steps, when steps were halved.

#include <dovetail/output/progress_bar.h>

#include <cmath>
#include <iostream>

using namespace dovetail;

int main()
{
  for (const double share : {0., 0.49, 0.5, 1., 4. / 2, 1e300, -0.1, HUGE_VAL, -HUGE_VAL, std::nan("")})
    std::cout << progress_bar(share) << share << std::endl;
}
