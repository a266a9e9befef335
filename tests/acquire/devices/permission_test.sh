#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# `dermap devices` of a user who may not write to the devices: it prints the udev rule as it is shipped; with the permission
# that the rule gives, it does not. Run by root it becomes nobody, whom permissions bind. Ends with 77 (skipped) where root
# cannot.
# Usage: permission_test.sh DERMAP EMULATOR RULE
set -euo pipefail
if [ "$1" = --in-emulator ]; then # MODE DERMAP: below the emulator, whose bus lies in $UMOCKDEV_DIR
  chmod -R a+rwX "$UMOCKDEV_DIR"
  chmod "$2" "$UMOCKDEV_DIR"/dev/bus/usb/001/*
  become=()
  [ "$(id -u)" -ne 0 ] || become=(setpriv --reuid=65534 --regid=65534 --clear-groups)
  exec "${become[@]}" "$3" devices
fi
dermap=$1 emulator=$2 rule=$3
if [ "$(id -u)" -eq 0 ] && ! setpriv --reuid=65534 --regid=65534 --clear-groups test -x "$dermap"; then
  echo "nobody cannot run $dermap" >&2
  exit 77
fi
devices() { "$emulator" -- "$0" --in-emulator "$1" "$dermap"; }
fail() {
  echo "$1:" >&2
  echo "$said" >&2
  exit 1
}

code=0
said=$(devices a-w) || code=$?
[ $code -eq 3 ] || fail "without permission it ends with $code, expected 3"
[ "$(grep -c 'install the udev rule below' <<<"$said")" -eq 2 ] || fail "expected camera and wheel to lack the rule"
grep -q 'sudo install -m 644 .*60-dermap.rules /etc/udev/rules.d/' <<<"$said" || fail "it does not say how to install it"
[[ "$said" == *"$(cat "$rule")"* ]] || fail "it does not print the rule"

code=0
said=$(devices a+w) || code=$?
[ $code -eq 0 ] || fail "with permission it ends with $code"
[ "$(grep -c ', ready' <<<"$said")" -eq 2 ] || fail "expected camera and wheel to be ready"
! grep -q 'udev rule' <<<"$said" || fail "it asks for the rule all the same"
