set(engine_packages libbullet-dev)
set(engine_headers "^(Bullet|LinearMath/|bt[A-Z][A-Za-z]*[.]h$)")
find_path(BULLET_INCLUDE BulletDynamics/Featherstone/btMultiBody.h PATH_SUFFIXES bullet)
# The double-precision build, which lies beside the other under names of its own.
find_library(BULLET_DYNAMICS_LIBRARY BulletDynamics-float64)
find_library(BULLET_COLLISION_LIBRARY BulletCollision-float64)
find_library(BULLET_MATH_LIBRARY LinearMath-float64)
set(engine_includes ${BULLET_INCLUDE})
set(engine_libraries ${BULLET_DYNAMICS_LIBRARY} ${BULLET_COLLISION_LIBRARY} ${BULLET_MATH_LIBRARY})
