"""Perceive: who is near whom (paper 2.4). No physics here, only positions."""
