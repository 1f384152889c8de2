#!/bin/sh
# A child that stays until it is told to end.
exec sleep 300
