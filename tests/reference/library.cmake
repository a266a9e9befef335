# SPDX-License-Identifier: Apache-2.0
# The judges as a library: studies are held to them as well as tests, so it is built without tests too.
dermap_library(dermap_reference ${CMAKE_CURRENT_LIST_DIR}/adding_doubling.cpp ${CMAKE_CURRENT_LIST_DIR}/monte_carlo.cpp
               ${CMAKE_CURRENT_LIST_DIR}/photon.cpp ${CMAKE_CURRENT_LIST_DIR}/quadrature.cpp)
target_link_libraries(dermap_reference PUBLIC Eigen3::Eigen Threads::Threads)
