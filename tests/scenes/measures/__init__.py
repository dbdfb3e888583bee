"""Measures: functions of one or more runs that return one number each."""
