#!/bin/sh
# Prints, for each kind of parents and each steer, the rows "diverse" and "steered" of
# `brood bench brood`. Run with brood in the PATH.
for kind in wild believable models; do
  for steer in keep-colour only-gloss warmer cooler rougher glossier more-pattern less-pattern \
    warmer,glossier; do
    case "$kind $steer" in "models more-pattern" | "models less-pattern") continue ;; esac
    echo "$kind $steer"
    brood bench brood --kind "$kind" --steer "$steer" --count 24 --seed 5 --size 16 |
      grep -E "^(diverse|steered)"
  done
done
