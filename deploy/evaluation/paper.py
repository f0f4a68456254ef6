"""The paper's own results in cm, to print ours beside.

Choi, Kwon, Lee, Choi, Lee, "Multi-robot Mapping Using Omnidirectional-Vision SLAM Based on Fisheye Images", section V.
"""

from __future__ import annotations

STATIC_X_CM = 2.23  # distances between objects in the global map, section V.1.B
STATIC_Y_CM = 1.49

DYNAMIC_X_CM = 5.65  # paths against the ceiling camera, section V.2.B
DYNAMIC_Y_CM = 4.50
DYNAMIC_DISTANCE_CM = 7.32

OTHER_SYSTEMS_CM = {  # distance errors of Table 1
    "Ladybug camera, 2012": 8.51,
    "spherical image, 2011": 7.11,
    "upward camera and CHL map, 2007": 19.6,
    "topological navigation, 2007": 11.0,
    "scan matching, 2006": 10.0,
}
